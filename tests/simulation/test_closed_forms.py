"""The hand and its parts where a closed form is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import FRICTIONLESS, Bench
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar
from scipy.special import ellipk

from hannes.contact import penalty, section
from hannes.core.kernels import smooth_switches
from hannes.core.kernels.jit import plain
from hannes.dynamics import finger, friction, joints, wires
from hannes.simulation.hand.hand import Hand

FREE = FRICTIONLESS | {"controller.sampled": 1.0}  # duty held at 0: no current flows at rest
NO_SPRINGS = {
    "mcp.spring_stiffness": 0.0,
    "mcp.spring_preload": 0.0,
    "pip.spring_stiffness": 0.0,
    "pip.spring_preload": 0.0,
}


# --- pendulum ---------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [0.01, 1.0, 2.5])
def test_period_of_a_heavy_rod(amplitude):
    """A rod hanging along x swings with 4 sqrt(2 L / 3 g) K(sin^2(A / 2)) whatever A."""
    rods = (0.05, 0.04, 0.015, 1e-12)  # a second link too light to matter

    def rates(time, state):
        q1, q2, w1, w2 = state
        torques = finger.gravity_torque(q1, q2, 9.81, 0.0, *rods)
        return (w1, w2, *finger.accelerations(*torques, q2, w1, w2, *rods))

    period = 4.0 * math.sqrt(2.0 * 0.05 / (3.0 * 9.81)) * ellipk(math.sin(amplitude / 2.0) ** 2)
    found = solve_ivp(
        rates, (0.0, period), (amplitude, 0.0, 0.0, 0.0), "DOP853", rtol=1e-11, atol=1e-12
    )
    assert found.y[0, -1] == pytest.approx(amplitude, rel=1e-6)
    quarter = solve_ivp(
        rates, (0.0, period / 4.0), (amplitude, 0.0, 0.0, 0.0), "DOP853", rtol=1e-11, atol=1e-12
    )
    assert quarter.y[0, -1] == pytest.approx(0.0, abs=1e-7 * amplitude)


def mass_matrix(fingers, bend):
    """Mass matrix of one finger of the bench at PIP angle `bend`, from its kinetic energy."""
    rods = [fingers[f"index.{link}_{what}"] for what in ("length", "mass") for link in RODS]
    diagonal = [2.0 * finger.kinetic_energy(bend, *speeds, *rods) for speeds in ((1, 0), (0, 1))]
    both = 2.0 * finger.kinetic_energy(bend, 1.0, 1.0, *rods)
    cross = 0.5 * (both - sum(diagonal))
    return np.array([[diagonal[0], cross], [cross, diagonal[1]]]), rods


RODS = ("second", "third")


def test_hanging_finger_swings_in_its_normal_modes():
    """A free finger about its hanging pose: q(t) = a v cos(w t), error of order a^2."""
    values = FREE | NO_SPRINGS | {"gravity.x": 9.81, "gravity.z": 0.0}
    values |= {"index.rest_mcp": -0.5, "index.rest_pip": -0.5}
    bench = Bench(values)
    masses, rods = mass_matrix(Hand().parameters, 0.0)
    l1, l2, m1, m2 = rods
    proximal, distal = 9.81 * (0.5 * m1 + m2) * l1, 9.81 * 0.5 * m2 * l2
    stiffness = np.array([[proximal + distal, distal], [distal, distal]])
    squares, modes = eigh(stiffness, masses)
    for square, mode in zip(squares, modes.T, strict=True):
        start = bench.rest.copy()
        at = bench.place("joint_angle").start
        start[at : at + 2] = 1e-4 * mode / np.abs(mode).max()
        times = np.linspace(0.0, 2.0 * np.pi / math.sqrt(square), 50)
        moved = bench.move(slack(bench, start), times)[:, at : at + 2]
        expected = np.outer(np.cos(math.sqrt(square) * times), start[at : at + 2])
        assert np.abs(moved - expected).max() < 1e-6 * 1e-4 + 1e-4**2


def slack(bench, state):
    """The same state with all wire let off, motor unpowered, so that no wire is taut."""
    state[bench.place("cart_position")] = -0.02
    state[bench.place("motor_angle")] = -1000.0
    return state


def test_released_finger_follows_its_springs():
    """A quarter period on the re-opening springs alone: q - q_rest = a v cos(w t)."""
    values = FREE | {"gravity.z": 0.0, "mcp.spring_preload": 0.0, "pip.spring_preload": 0.0}
    bench = Bench(values)
    shipped = Hand().parameters
    masses, _ = mass_matrix(shipped, shipped["index.rest_pip"])
    stiffness = np.diag([shipped["mcp.spring_stiffness"], shipped["pip.spring_stiffness"]])
    squares, modes = eigh(stiffness, masses)
    mode = modes[:, 0] * np.sign(modes[0, 0])
    assert (mode > 0.0).all()  # both joints closed, so that no stop is met on the way back
    frequency, at = math.sqrt(squares[0]), bench.place("joint_angle").start
    start = bench.rest.copy()
    start[at : at + 2] += 1e-4 * mode / mode.max()
    times = np.linspace(0.0, 0.5 * np.pi / frequency, 50)
    moved = bench.move(slack(bench, start), times)[:, at : at + 2] - bench.rest[at : at + 2]
    expected = np.outer(np.cos(frequency * times), start[at : at + 2] - bench.rest[at : at + 2])
    assert np.abs(moved - expected).max() < 1e-4 * 1e-4


def test_open_hand_rests_exactly():
    bench = Bench({})
    for name in ("mcp", "pip"):
        at = 0 if name == "mcp" else 1
        rest, table = bench.rest[bench.place("joint_angle")][at], bench.compiled.parameters
        stiffness = bench.p[table["joint_stop_stiffness"]][at]
        preload = bench.p[table["joint_spring_preload"]][at]
        stop = joints.stop_torque(rest, 0.0, rest, rest + 1.0, preload, stiffness, 0.02, 1e-3)
        assert stop == pytest.approx(preload, rel=1e-10)
    assert np.abs(bench.rates(0.0, bench.rest)).max() < 1e-9


# --- motor ------------------------------------------------------------------------------------


def test_motor_step_response_is_two_exponentials():
    """L i' = V - R i - k w and J w' = k i - f w after a step of voltage, the wire unwinding."""
    values = {"motor.dry_friction": 0.0, "motor.viscous_friction": 2e-6, "controller.sampled": 1.0}
    bench = Bench(values | {"motor.inductance": 2e-3})
    bench.memory[0] = -0.5  # duty; backwards, so that the leader stays slack
    shipped = Hand().parameters
    voltage = -0.5 * shipped["supply.voltage"]
    resistance, constant = shipped["motor.resistance"], shipped["motor.torque_constant"]
    inductance, inertia, viscous = 2e-3, shipped["motor.inertia"], 2e-6
    trace = resistance / inductance + viscous / inertia
    product = (resistance * viscous + constant**2) / (inductance * inertia)
    root = math.sqrt(trace**2 / 4.0 - product)
    fast, slow = -trace / 2.0 - root, -trace / 2.0 + root
    final_current = voltage * viscous / (resistance * viscous + constant**2)
    final_speed = voltage * constant / (resistance * viscous + constant**2)
    times = np.linspace(0.0, 0.1, 200)

    def response(final, rise):
        """Two exponentials from 0 with slope `rise` to `final`."""
        a = (rise + slow * final) / (fast - slow)
        return final + a * np.exp(fast * times) - (final + a) * np.exp(slow * times)

    moved = bench.move(bench.rest, times)
    current = moved[:, bench.place("motor_current").start]
    speed = moved[:, bench.place("motor_speed").start]
    assert np.abs(current - response(final_current, voltage / inductance)).max() < 1e-7
    assert np.abs(speed - response(final_speed, 0.0)).max() < 1e-7 * abs(final_speed)


# --- friction ---------------------------------------------------------------------------------

LEVELS = st.floats(1e-4, 1.0)


@given(LEVELS, LEVELS, st.floats(1e-3, 100.0))
def test_friction_at_the_breakaway_speed_is_the_breakaway_friction(coulomb, more, speed):
    """Eq. 1 without its viscous part equals T_bf at w_bf but for T_cf (1 - tanh 10) = 4e-9 T_cf.

    Its exponential term alone peaks exactly there, with T_bf - T_cf.
    """
    breakaway = coulomb + more
    at = plain(friction.stribeck)(speed, breakaway, coulomb, speed, 0.0)
    assert at == pytest.approx(breakaway, rel=5e-9)
    term = plain(friction.stribeck)(speed, more, 0.0, speed, 0.0)
    assert term == pytest.approx(more, rel=1e-12)
    for aside in (0.99, 1.01):
        assert plain(friction.stribeck)(aside * speed, more, 0.0, speed, 0.0) < term


def test_friction_peaks_at_the_breakaway_speed():
    found = minimize_scalar(
        lambda w: -friction.stribeck(w, 0.0139, 0.0107, 10.47, 0.0),
        bracket=(5.0, 10.0, 20.0),
        tol=1e-12,
    )
    assert found.x == pytest.approx(10.47, rel=1e-5)
    assert -found.fun == pytest.approx(0.0139, rel=1e-8)


@given(st.floats(-1e3, 1e3), LEVELS, LEVELS, st.floats(1e-3, 100.0), LEVELS)
def test_friction_is_odd_and_opposes_motion(speed, breakaway, coulomb, width, viscous):
    law = plain(friction.stribeck)
    levels = (max(breakaway, coulomb), coulomb, width, viscous)
    assert law(speed, *levels) == -law(-speed, *levels)
    assert law(speed, *levels) * speed >= 0.0


# --- one-sided springs ------------------------------------------------------------------------


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.2, 0.5])
def test_rebound_of_a_spring_damper(damping_ratio):
    """Speed after over speed before: exp(-z w_0 t), t when the force has fallen to zero.

    For z = c / (2 sqrt(k m)) the force k x + c x' vanishes at w_d t = pi - atan2(2 z s, 1 - 2 z^2)
    with s = sqrt(1 - z^2) (Schwager & Poeschel 2007). The damping's onset is taken to be short.
    """
    mass, stiffness, speed = 0.01, 8000.0, 0.5
    natural = math.sqrt(stiffness / mass)
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * mass)
    root = math.sqrt(1.0 - damping_ratio**2)
    lasts = math.pi - math.atan2(2.0 * damping_ratio * root, 1.0 - 2.0 * damping_ratio**2)
    expected = math.exp(-damping_ratio / root * lasts)
    narrow = 1e-6 * speed / natural

    def rates(time, state):
        push = max(0.0, penalty.normal_law(state[0], state[1], stiffness, damping, narrow))
        return state[1], -push / mass

    found = solve_ivp(rates, (0.0, 8.0 / natural), (0.0, speed), "Radau", rtol=1e-9, atol=1e-12)
    assert -found.y[1, -1] / speed == pytest.approx(expected, rel=2e-5)


@given(st.floats(-0.1, 0.1), st.floats(-10, 10), st.floats(0, 1e5), st.floats(0, 1e3))
def test_a_wire_never_pulls_before_it_is_taut_and_never_pushes(stretch, rate, stiffness, damping):
    pull = plain(wires.tension)(stretch, rate, stiffness, damping, 2e-5)
    assert pull >= 0.0
    assert pull == 0.0 or stretch > 0.0


@given(st.floats(-10, 10), st.floats(1, 1e5), st.floats(0, 1e3), st.floats(1e-6, 1e-3))
def test_a_wire_becomes_taut_without_a_jump(rate, stiffness, damping, onset_width):
    hair = 1e-7 * onset_width
    pull = plain(wires.tension)(hair, rate, stiffness, damping, onset_width)
    assert pull <= stiffness * hair + damping * abs(rate) * 4e-14


@given(st.floats(-1, 1), st.floats(-50, 50), st.floats(0, 1))
def test_stops_only_push_back(angle, speed, preload):
    torque = plain(joints.stop_torque)(angle, speed, -0.5, 0.5, preload, 6.0, 0.02, 1e-3)
    if -0.5 + preload / 6.0 < angle < 0.5:
        assert torque == 0.0
    elif angle > 0.5 and angle > -0.5 + preload / 6.0:
        assert torque <= 0.0
    elif angle < 0.5:
        assert torque >= 0.0


# --- smooth switches --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("switch", "corners"),
    [
        (lambda x: plain(smooth_switches.smoothstep)(x), (0.0, 1.0)),
        (lambda x: plain(smooth_switches.limited)(x, 12.0), (-12.24, -11.76, 11.76, 12.24)),
    ],
)
def test_switches_have_no_corner(switch, corners):
    step = 1e-6
    for corner in corners:
        before = (switch(corner) - switch(corner - step)) / step
        after = (switch(corner + step) - switch(corner)) / step
        assert before == pytest.approx(after, abs=2e-5)
    line = np.linspace(-15, 15, 4001)
    values = np.array([switch(x) for x in line])
    assert (np.diff(values) >= 0.0).all()


@given(st.floats(-100, 100), st.floats(0.1, 50))
def test_limited_keeps_to_its_limit_and_leaves_the_inside_alone(x, limit):
    found = plain(smooth_switches.limited)(x, limit)
    assert abs(found) <= limit * (1 + 1e-12)
    assert found == -plain(smooth_switches.limited)(-x, limit)
    if abs(x) <= 0.98 * limit:
        assert found == x


# --- distance to sections ---------------------------------------------------------------------

STEP = 1e-7  # m, to difference by
CORES = [(0.0, 0.0), (0.02, 0.01), (0.03, 0.0)]


def outline(half_x, half_y, count=4001):
    """Points on the border of a rectangle, shape (4 count, 2)."""
    side = np.linspace(-1.0, 1.0, count)
    ones = np.ones(count)
    parts = [(side, ones), (side, -ones), (ones, side), (-ones, side)]
    return np.concatenate([np.stack([half_x * x, half_y * y], 1) for x, y in parts])


@pytest.mark.parametrize("core", CORES)
def test_signed_distance_against_brute_force(core):
    border = outline(*core)
    for point in np.random.default_rng(4).uniform(-0.06, 0.06, (200, 2)):
        found, *gradient = section.signed_distance(*point, *core)
        size = np.linalg.norm(border - point, axis=1).min()
        if (np.abs(point) < core).all():
            depths = np.array(core) - np.abs(point)
            assert found == pytest.approx(-(np.sum(depths**-8.0) ** -0.125), rel=1e-9)
            assert 2.0**-0.125 * size - 1e-6 <= -found <= size + 1e-6
        else:
            assert found == pytest.approx(size, abs=1e-6)
            assert np.hypot(*gradient) == pytest.approx(1.0, rel=1e-12)
        for axis, slope in zip(np.eye(2), gradient, strict=True):
            ends = [
                section.signed_distance(*(point + side * axis), *core)[0] for side in (-STEP, STEP)
            ]
            assert (ends[1] - ends[0]) / (2.0 * STEP) == pytest.approx(slope, abs=1e-4)


def links(core, count=200):
    """Links that do not cut the core: start, direction, length."""
    rng = np.random.default_rng(5)
    while count:
        start, turn, length = (
            rng.uniform(-0.08, 0.08, 2),
            rng.uniform(0, 7),
            rng.uniform(0.03, 0.06),
        )
        ahead = np.array([np.cos(turn), np.sin(turn)])
        line = start + np.linspace(0.0, length, 2001)[:, np.newaxis] * ahead
        over = np.abs(line) - core
        gaps = np.hypot(*np.maximum(over, 0.0).T) + np.minimum(over.max(axis=1), 0.0)
        if gaps.min() > 1e-3:
            count -= 1
            yield start, ahead, length, gaps


@pytest.mark.parametrize("core", CORES)
def test_place_of_contact_is_the_nearest(core):
    """Exact for circles; for rounded rectangles within the 0.2 mm of its blend."""
    allowed = 1e-6 if core == (0.0, 0.0) else 0.2e-3
    for start, ahead, length, gaps in links(core):
        place = section.contact_place(*start, *ahead, length, *core)
        assert -1e-12 <= place <= length + 1e-12
        gap = section.signed_distance(*(start + place * ahead), *core)[0]
        assert gaps.min() - 1e-6 <= gap <= gaps.min() + allowed


def test_place_of_contact_moves_without_a_jump():
    """A link tilting over a flat side hands the contact from one end to the other smoothly."""
    places = []
    for tilt in np.linspace(-0.2, 0.2, 2001):
        ahead = np.array([math.cos(tilt), math.sin(tilt)])
        start = np.array([0.0, 0.02]) - 0.015 * ahead
        places.append(section.contact_place(*start, *ahead, 0.03, 0.04, 0.01))
    assert places[0] == pytest.approx(0.03, abs=1e-6) or places[0] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(np.diff(places)).max() < 1e-3
