"""The Jacobian by stages against plain differences, and its solution against numpy's."""

import functools
import os
import subprocess
import sys

import numpy as np
import pytest
from runs import GRASP, reference, run

from hannes.control.firmware_memory import MEMORY
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.simulation.catalogue import effects
from hannes.simulation.experiment.experiment import Experiment, Target
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate


def made(name, term, *states):
    """An effect of a test with one amplitude `size`."""
    size = Parameter("size", 0.0, "1", (-1e6, 1e6), "amplitude", off=0.0)
    terms = term if isinstance(term, tuple) else (term,)
    return Effect(name, "It is a test.", "x += size f", "a test", (size,), terms, states)


@kernel
def bristle(joint_speed, z, size):
    """A friction with a state of its own at each joint."""
    return size * 1e-3 * z, joint_speed - abs(joint_speed) * z


@kernel
def warmth(motor_current, heat, size):
    """A resistance that grows with the heat of the winding."""
    return size * heat, motor_current**2 - 0.1 * heat


@kernel
def weaker(heat, size):
    """A torque constant that falls with it."""
    return -1e-4 * size * heat


@kernel
def shaking(motor_speed, joint_angle, size, t):
    """Every joint feels the motor turn, and the time."""
    return size * 1e-6 * motor_speed * joint_angle + size * 1e-3 * np.sin(50.0 * t)


@kernel
def routed(tendon_tension, excursion, excursion_rate, size):
    """A wire that rubs the more the more of it is taken up."""
    return -1e-2 * size * tendon_tension * excursion * 1e2 - size * 1e-3 * excursion_rate


@kernel
def loaded(tendon_tension, joint_speed, size):
    """Joint friction that grows with the wire's tension."""
    return size * 1e-5 * tendon_tension * joint_speed


@kernel
def stretching(tendon_tension, longer, size):
    """A wire that creeps, one state a finger."""
    return -size * longer, 1e-3 * tendon_tension - longer


@kernel
def dragging(cart_speed, worn, size):
    """A guide that wears, one state a cart."""
    return size * worn, abs(cart_speed) - worn


@kernel
def followed(motor_angle, size):
    """A bench that the motor pulls along."""
    return size * 1e-4 * motor_angle


@kernel
def saturating(voltage, t, size):
    """A torque constant that falls with the voltage, and in time."""
    return -1e-6 * size * voltage * (1.0 + np.sin(50.0 * t))


@kernel
def hunting(motor_speed, size):
    """A friction that no differentiation follows: a loop that ends by what it finds."""
    x = 0.1 * abs(motor_speed) + 1.0
    while x > 2.0:
        x *= 0.5
    return 1e-4 * size * x


@kernel
def clicking(joint_angle, size):
    """The same at each joint."""
    x = abs(joint_angle) + 0.1
    while x > 0.3:
        x *= 0.5
    return 1e-3 * size * x


@kernel
def sticky(penetration, penetration_rate, film, size):
    """A contact whose film is pressed out, and drawn in."""
    return size * 0.1 * (penetration_rate + film), penetration_rate - film


@kernel
def coupled(joint_angle, size):
    """Fingers push the object about: no arrow."""
    return size * 1e-4 * joint_angle[0] * joint_angle[4]


OWN = {
    "bristle": made(
        "bristle",
        Term(bristle, ("joint_friction",), ("z",)),
        Slot("z", "rad", "of the bristle", "joint", 10, 1e-4),
    ),
    "heating": made(
        "heating",
        (Term(warmth, ("resistance",), ("heat",)), Term(weaker, ("torque_constant",))),
        Slot("heat", "A2 s", "of the winding", tolerance=1e-3),
    ),
    "shaking": made("shaking", Term(shaking, ("joint_torque",))),
    "routed": made("routed", Term(routed, ("tendon_tension",))),
    "loaded": made("loaded", Term(loaded, ("joint_friction",))),
    "stretching": made(
        "stretching",
        Term(stretching, ("tendon_tension",), ("longer",)),
        Slot("longer", "m", "of the wire", "finger", 5, 1e-3),
    ),
    "dragging": made(
        "dragging",
        Term(dragging, ("cart_friction",), ("worn",)),
        Slot("worn", "m", "of the guide", "cart", 2, 1e-6),
    ),
    "hunting": made("hunting", Term(hunting, ("gear_friction",))),
    "clicking": made("clicking", Term(clicking, ("joint_friction",))),
    "sticky": made(
        "sticky",
        Term(sticky, ("normal_force",), ("film",)),
        Slot("film", "m/s", "of the contact", "phalanx", 10, 1e-4),
    ),
    "followed": made("followed", Term(followed, ("object_x",))),
    "saturating": made("saturating", Term(saturating, ("torque_constant",))),
    "coupled": made("coupled", Term(coupled, ("object_x",))),
}
CASES = {
    "none": (),
    "catalogue": tuple(effects()),
    "states of a finger and of the core": ("bristle", "heating", "clicking", "sticky"),
    "fingers that see the core": ("shaking", "loaded"),
    "wires": ("routed", "stretching", "dragging", "hunting"),
    "an object that moves, a constant that does not stay": ("followed", "saturating"),
    "no arrow": ("coupled",),
}
KNOTS, HELD = reference(GRASP).knots, np.zeros(MEMORY)


@functools.cache
def posed(names):
    """Hand with the named effects at an amplitude that matters."""
    hand = Hand().with_effects(*(OWN.get(name, name) for name in names))
    values = {
        effect.full_name(each.name): min(0.9, 0.05 * each.bounds[1])
        for effect in hand.effects
        for each in effect.amplitudes
    }
    return hand.with_values(values)


@functools.cache
def grasped():
    """Times and states of a grasp: free, touching, at the stops, slack and taut."""
    found, places = run(rtol=1e-5), [0, 60, 300, 330, 345, 500, 660, 900, 1080]
    return found.time[places], found.states[places]


def states(compiled, known):
    """Random states about known ones."""
    scale = [slot.tolerance for slot in compiled.states.slots for _ in range(slot.size)]
    rng, more = np.random.default_rng(7), np.zeros(compiled.states.size - 31)
    for time, core in zip(*known, strict=True):
        state = np.concatenate([core, more])
        yield time, state + 30.0 * rng.normal(size=state.size) * scale


@functools.cache
def solved(compiled):
    """Compiled: fill columns with df/dy and drift with df/dt; solve with shift - df/dy for b."""
    fast, kind = compiled.fast, compiled.fast.WORKSPACE
    prepare, slope, linearise = fast.prepare, fast.slope, fast.linearise
    gather, decompose, resolve = fast.gather, fast.decompose, fast.resolve

    @kernel
    def within(room, t, y, p, reference, memory, shift, columns, drift, b):
        data, rates = room[0], np.zeros(y.size)
        prepare(data, p, reference, memory)
        slope(t, y, rates, data)
        linearise(t, y, rates, drift, data)
        gather(data, columns)
        decompose(shift, data)
        resolve(b, data)

    @kernel
    def both(t, y, p, reference, memory, shift, columns, drift, b):
        within(np.zeros(1, kind), t, y, p, reference, memory, shift, columns, drift, b)

    return both


def moves(compiled, state):
    """How far each state is moved to difference the rates."""
    return 1e-7 * np.maximum(np.abs(state), compiled.fast.steps)


def require_slopes(columns, theirs, rates, moved, time):
    """A Jacobian is that of differences, but for the last digits of the rates."""
    scale = np.abs(theirs) + 1e-4 * np.abs(theirs).max(axis=1, keepdims=True) + 1e-9
    last_digits = 8.0 * np.spacing(np.abs(rates))[:, None] / moved
    assert ((np.abs(columns - theirs) - last_digits) / scale).max() < 1e-3, time


def compared(hand, shape, shifts, known):
    """Jacobian and df/dt against plain differences, the solution against numpy's."""
    compiled, p = hand.compiled(), hand.vector(shape)
    n, rng = compiled.states.size, np.random.default_rng(8)
    for time, state in states(compiled, known):
        columns, drift = np.zeros((n, n)), np.zeros(n)
        for shift in shifts:
            b = rng.normal(size=n) * (np.abs(state) + 1e-3)
            mine = b.copy()
            solved(compiled)(time, state, p, KNOTS, HELD, shift, columns, drift, mine)
            numpys = np.linalg.solve(shift * np.eye(n) - columns, b)
            assert np.abs(mine - numpys).max() < 1e-9 * np.abs(numpys).max()
        theirs = compiled.fast.differences(time, state, p, KNOTS, HELD)
        now, later = (compiled.fast.rates(time + d, state, p, KNOTS, HELD) for d in (0.0, 1e-5))
        require_slopes(columns, theirs, now, moves(compiled, state), time)
        changes = (later - now) / 1e-5  # onwards: at the start the reference has a kink
        rounding = 1e-10 * np.abs(now).max()
        assert np.abs(drift - changes).max() < 1e-3 * np.abs(changes).max() + rounding, time


def held(case, known):
    """A case of the right kind whose Jacobian and solution are right."""
    hand = posed(CASES[case])
    kind = hand.compiled().jacobian_kind
    assert kind.startswith("dense" if case == "no arrow" else "structured"), (case, kind)
    compared(hand, "cylinder", (1e3, 1e5), known)


def test_the_compiled_jacobian_is_the_slope_of_the_compiled_rates():
    """By the entry points that stock methods call; their solution with it is compiled below."""
    hand = posed(())
    compiled, p = hand.compiled(), hand.vector("cylinder")
    for time, state in states(compiled, grasped()):
        moved, now = moves(compiled, state), compiled.fast.rates(time, state, p, KNOTS, HELD)
        theirs = np.empty((state.size, state.size))
        for j, far in enumerate(moved):
            there = state.copy()
            there[j] += far
            rates = compiled.fast.rates(time, there, p, KNOTS, HELD)
            theirs[:, j] = (rates - now) / (there[j] - state[j])
        columns = compiled.fast.jacobian(time, state, p, KNOTS, HELD)
        require_slopes(columns, theirs, now, moved, time)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["none", "catalogue"])
def test_jacobian_and_solution_against_plain_differences_and_numpy(case):
    held(case, grasped())


def in_plain_python(call, folder):
    """Run a function of this file where nothing is compiled, on known states."""
    np.savez(folder / "known.npz", *grasped())
    code = (
        "import functools, numpy, test_hand_jacobian\n"
        f"known = numpy.load({str(folder / 'known.npz')!r})\n"
        f"{call}(known=(known['arr_0'], known['arr_1']))"
    )
    path = os.pathsep.join([os.path.dirname(__file__), *sys.path])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


@pytest.mark.parametrize("case", [case for case in CASES if case not in ("none", "catalogue")])
def test_those_of_other_effects_in_plain_python(case, tmp_path):
    """What is generated for them is right; that it compiles as it reads, tests above show."""
    in_plain_python(f"functools.partial(test_hand_jacobian.held, {case!r})", tmp_path)


def no_bit_changed(known):
    """The catalogue at off, all of it, leaves the hand's rates what they are without it.

    Its kernels do not run, so its own states stand, and their slopes are zero.
    """
    bare, dressed = Hand(), Hand(list(effects()))
    fast = dressed.compiled(dressed.effects).fast
    p = bare.vector("cylinder", ()), dressed.vector("cylinder", dressed.effects)
    for time, state in states(bare.compiled(), known):
        more = np.zeros(dressed.compiled(dressed.effects).states.size - state.size)
        whole = np.concatenate([state, more])
        found = fast.rates(time, whole, p[1], KNOTS, HELD)
        without = bare.compiled().fast.rates(time, state, p[0], KNOTS, HELD)
        assert np.array_equal(found[: state.size], without), time
        assert more.size and not found[state.size :].any(), time
    assert not fast.jacobian(time, whole, p[1], KNOTS, HELD)[state.size :].any()


def test_effects_at_off_change_no_bit(tmp_path):
    in_plain_python("test_hand_jacobian.no_bit_changed", tmp_path)


PRISM = {"object.half_x": 0.02, "object.half_y": 0.015, "object.radius": 0.005}
VARIANTS = [
    ({"gravity.x": 3.0, "gravity.y": -9.0}, "cylinder"),
    ({**PRISM, "object.y": -0.05, "object.friction": 0.0}, "prism"),
    ({"object.radius": 0.04, "object.z": 0.01}, "sphere"),
    ({"controller.sampled": 1.0}, "cylinder"),
    ({"controller.sampled": 1.0}, None),
    ({"position_pid.limit": 0.5, "supply.voltage": 2.0}, "cylinder"),
    ({"mcp.breakaway_speed": 0.1, "cart.breakaway_speed": 1e-3}, "cylinder"),
]


def varied(case, known, every=1):
    """Weight, flat sides, a ball, firmware, limits that are reached, steep friction.

    every: each of them on one in so many of the states, all states being met in turn.
    """
    for k, (values, shape) in enumerate(VARIANTS):
        some = tuple(each[k % every :: every] for each in known)
        compared(posed(CASES[case]).with_values(values), shape, (1e4,), some)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["none", "catalogue"])
def test_other_values_have_the_right_slopes_too(case):
    varied(case, grasped())


@pytest.mark.parametrize("case", ["none", "catalogue"])
def test_other_values_in_plain_python(case, tmp_path):
    in_plain_python(f"functools.partial(test_hand_jacobian.varied, {case!r}, every=3)", tmp_path)


@pytest.mark.parametrize(
    "names, derived",
    [((), True), (tuple(effects()), True), (("bristle", "sticky"), True), (("loaded",), False)],
)
def test_fingers_are_differenced_only_where_nothing_else_helps(names, derived):
    hand = Hand([OWN.get(name, name) for name in names])
    assert hand.compiled(hand.effects).jacobian_kind == "structured"
    assert hasattr(hand.compiled(hand.effects).fast, "solve_columns") == derived


def test_what_does_not_fit_is_said():
    kind = posed(("coupled",)).compiled().jacobian_kind
    assert kind == "dense differences, because coupled reads all of joint_angle"
    text = " ".join(str(posed(("coupled",))).split())
    assert f"slower to simulate: {kind}" in text
    assert "slower to simulate" not in str(posed(("bristle",)))


@pytest.mark.slow
def test_a_coupled_hand_moves_like_with_a_stock_method():
    hand = posed(("coupled",))
    experiment = Experiment("coupled", 0.4, reference(GRASP), Target("cylinder"))
    mine, theirs = (
        simulate(hand, experiment, method=method, rtol=1e-6).require()["force"]
        for method in ("Rodas", "Radau")
    )
    assert np.abs(mine - theirs).max() < 1e-3 * theirs.max()
