"""The Jacobian by stages against plain differences, and its solution against numpy's."""

import numpy as np
import pytest
from runs import GRASP, grasp, reference

from hannes._jit import kernel
from hannes.catalogue import effects
from hannes.effect import Effect, Term
from hannes.experiment import Experiment, Target
from hannes.hand import Hand
from hannes.layout import Slot
from hannes.parameter import Parameter
from hannes.simulate import simulate


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
        Slot("longer", "m", "of the wire", "finger", 5, 1e-6),
    ),
    "dragging": made(
        "dragging",
        Term(dragging, ("cart_friction",), ("worn",)),
        Slot("worn", "m", "of the guide", "cart", 2, 1e-6),
    ),
    "coupled": made("coupled", Term(coupled, ("object_x",))),
}
CASES = [(), *((name,) for name in effects()), *((name,) for name in OWN), ("bristle", "heating")]
SHIPPED = {"leader_slack.length": 1e-3}


def posed(names):
    """Hand with the named effects at an amplitude that is felt."""
    found = [OWN.get(name, name) for name in names]
    hand = Hand().with_effects(*found)
    values = {}
    for effect in hand.effects:
        for each in effect.amplitudes:
            full = effect.full_name(each.name)
            values[full] = SHIPPED.get(full, 0.1 if each.bounds[1] < 1.0 else 0.9)
    return hand.with_values(values)


def states(hand, compiled):
    """Random states about those of a grasp: free, touching, at the stops, slack and taut."""
    run = simulate(hand, grasp(), method="LSODA", rtol=1e-5).require()
    scale = [slot.tolerance for slot in compiled.states.slots for _ in range(slot.size)]
    rng = np.random.default_rng(7)
    for k in (0, 60, 300, 330, 345, 500, 660, 900, 1080):
        yield run.time[k], run.states[k] + 30.0 * rng.normal(size=len(scale)) * scale


@pytest.mark.parametrize("names", CASES, ids=lambda names: "+".join(names) or "none")
def test_jacobian_by_stages_equals_plain_differences(names):
    hand = posed(names)
    compiled, p = hand.compiled(), hand.vector("cylinder")
    assert compiled.jacobian_kind.startswith("dense" if names == ("coupled",) else "structured")
    knots, hold = reference(GRASP).knots, np.zeros(7)
    for time, state in states(hand, compiled):
        mine = compiled.fast.jacobian(time, state, p, knots, hold)
        theirs = compiled.fast.differences(time, state, p, knots, hold)
        scale = np.abs(theirs) + 1e-5 * np.abs(theirs).max(axis=1, keepdims=True) + 1e-9
        assert (np.abs(mine - theirs) / scale).max() < 1e-3, time


@pytest.mark.parametrize("names", CASES, ids=lambda names: "+".join(names) or "none")
def test_solution_by_elimination_equals_numpys(names):
    hand = posed(names)
    compiled, p = hand.compiled(), hand.vector("cylinder")
    fast, n = compiled.fast, compiled.states.size
    rng = np.random.default_rng(8)
    for time, state in states(hand, compiled):
        matrix = fast.jacobian(time, state, p, reference(GRASP).knots, np.zeros(7))
        data = fast.workspace(state, p, reference(GRASP).knots, np.zeros(7))
        rates = np.zeros(n)
        fast.slope(time, state, rates, data)
        fast.linearise(time, state, rates, np.zeros(n), data)
        for shift in (1e3, 1e5):
            fast.decompose(shift, data)
            known = rng.normal(size=n) * (np.abs(state) + 1e-3)
            b = (shift * np.eye(n) - matrix) @ known
            fast.resolve(b, data)
            assert np.abs(b - known).max() < 1e-6 * np.abs(known).max()


def test_what_does_not_fit_is_said():
    kind = posed(("coupled",)).compiled().jacobian_kind
    assert kind == "dense differences, because coupled reads all of joint_angle"


def test_a_coupled_hand_moves_like_with_a_stock_method():
    hand = posed(("coupled",))
    experiment = Experiment("coupled", 0.4, reference(GRASP), Target("cylinder"))
    mine, theirs = (
        simulate(hand, experiment, method=method, rtol=1e-6).require()["force"]
        for method in ("Rodas", "Radau")
    )
    assert np.abs(mine - theirs).max() < 1e-3 * theirs.max()
