"""A finger's equations of motion against sympy's, and contact geometry against differences."""

import functools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from touch import Touch, moving, poses

from hannes.core.kernels.jit import plain
from hannes.dynamics import finger

LENGTHS, MASSES = st.floats(0.005, 0.2), st.floats(1e-4, 0.5)
ANGLES = st.floats(-3.2, 3.2)


@functools.cache
def lagrangian():
    """Functions of the state from the Lagrangian of two uniform rods: q'', T, -dV/dq, M.

    Energies are integrals over the rods, point by point: no moment of inertia is assumed.
    """
    import sympy  # here: each process of the suite collects all files

    q1, q2, w1, w2, torque_1, torque_2 = sympy.symbols("q1 q2 w1 w2 torque_1 torque_2")
    l1, l2, m1, m2, gx, gy, s = sympy.symbols("l1 l2 m1 m2 gx gy s")
    angles, speeds = sympy.Matrix([q1, q2]), sympy.Matrix([w1, w2])

    def direction(angle):
        return sympy.Matrix([sympy.cos(angle), -sympy.sin(angle)])

    on_first = s * direction(q1)
    on_second = l1 * direction(q1) + s * direction(q1 + q2)
    kinetic, potential = 0, 0
    for point, length, mass in ((on_first, l1, m1), (on_second, l2, m2)):
        velocity = point.jacobian(angles) * speeds
        kinetic += sympy.integrate(velocity.dot(velocity) * mass / length / 2, (s, 0, length))
        potential -= sympy.integrate(
            (gx * point[0] + gy * point[1]) * mass / length, (s, 0, length)
        )
    momentum = sympy.Matrix([kinetic]).jacobian(speeds)
    mass_matrix = momentum.jacobian(speeds)
    slope = sympy.Matrix([kinetic - potential]).jacobian(angles)
    drift = momentum.jacobian(angles) * speeds
    rates = mass_matrix.LUsolve(sympy.Matrix([torque_1, torque_2]) + slope.T - drift)
    state = (q1, q2, w1, w2, torque_1, torque_2, gx, gy, l1, l2, m1, m2)
    gravity = -sympy.Matrix([potential]).jacobian(angles)
    found = (rates, kinetic, gravity, mass_matrix)
    return [sympy.lambdify(state, each, "numpy", cse=True) for each in found]


@pytest.fixture(scope="module")
def states():
    """200 random states: angles, speeds, torques, gravity, lengths, masses."""
    low = [-3, -3, -20, -20, -1, -1, -10, -10, 0.02, 0.02, 0.005, 0.005]
    high = [3, 3, 20, 20, 1, 1, 10, 10, 0.08, 0.08, 0.05, 0.05]
    return np.random.default_rng(1).uniform(low, high, (200, 12))


def test_accelerations(states):
    expected, *_ = lagrangian()
    worst = 0.0
    for q1, q2, w1, w2, u1, u2, gx, gy, *rods in states:
        pull = finger.gravity_torque(q1, q2, gx, gy, *rods)
        mine = finger.accelerations(u1 + pull[0], u2 + pull[1], q2, w1, w2, *rods)
        theirs = expected(q1, q2, w1, w2, u1, u2, gx, gy, *rods).ravel()
        worst = max(worst, np.abs(mine - theirs).max() / np.abs(theirs).max())
    assert worst < 1e-10


def test_kinetic_energy_and_gravity(states):
    _, kinetic, gravity, _ = lagrangian()
    for state in states:
        q1, q2, w1, w2, _, _, gx, gy, *rods = state
        assert finger.kinetic_energy(q2, w1, w2, *rods) == pytest.approx(kinetic(*state), rel=1e-12)
        mine = finger.gravity_torque(q1, q2, gx, gy, *rods)
        assert mine == pytest.approx(gravity(*state).ravel(), rel=1e-11, abs=1e-15)


@given(ANGLES, LENGTHS, LENGTHS, MASSES, MASSES)
def test_mass_matrix_is_positive_definite(angle, length_1, length_2, mass_1, mass_2):
    rods = (length_1, length_2, mass_1, mass_2)
    still = plain(finger.accelerations)(0.0, 0.0, angle, 0.0, 0.0, *rods)
    assert still == (0.0, 0.0)
    columns = [plain(finger.accelerations)(*u, angle, 0.0, 0.0, *rods) for u in ((1, 0), (0, 1))]
    inverse = np.array(columns)
    assert inverse[0, 1] == pytest.approx(inverse[1, 0], rel=1e-9)
    assert inverse[0, 0] > 0.0 and np.linalg.det(inverse / inverse[0, 0]) > 0.0


@given(ANGLES, st.floats(-50, 50), st.floats(-50, 50), st.tuples(LENGTHS, LENGTHS, MASSES, MASSES))
def test_kinetic_energy_is_never_negative(angle, speed_1, speed_2, rods):
    scale = max(rods) ** 3 * (speed_1**2 + speed_2**2)
    assert plain(finger.kinetic_energy)(angle, speed_1, speed_2, *rods) >= -1e-12 * scale


SECTIONS = {
    "cylinder": {"object.x": 0.012, "object.y": -0.0455, "object.radius": 0.026},
    "prism": {
        "object.x": 0.03,
        "object.y": -0.05,
        "object.radius": 0.005,
        "object.half_x": 0.02,
        "object.half_y": 0.015,
    },
}


@pytest.mark.parametrize("phalanx", range(10))
def test_penetration_rate_is_the_rate_of_penetration(phalanx):
    touch, step = Touch("cylinder", SECTIONS["cylinder"]), 1e-6
    for angles, speeds in moving():
        deeper, before = (
            touch(angles + sign * step * speeds)("penetration")[phalanx] for sign in (1.0, -1.0)
        )
        mine = touch(angles, speeds)("penetration_rate")[phalanx]
        assert mine == pytest.approx((deeper - before) / (2.0 * step), rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("phalanx", range(10))
def test_penetration_rate_against_a_prism_is_that_of_the_touching_point(phalanx):
    """Along a flat side the place of contact is blended, so it is held while differencing."""
    touch, step, f = Touch("prism", SECTIONS["prism"]), 1e-6, phalanx // 2
    table = touch.bench.compiled.parameters
    p, (mcp, pip) = touch.bench.p, (2 * f, 2 * f + 1)
    lengths, facing = p[table["link_length"]], p[table["facing"]][f]
    mount = np.array([p[table["mount_x"]][f], p[table["mount_y"]][f]])
    centre = [SECTIONS["prism"][f"object.{axis}"] for axis in "xy"] - mount
    centre *= np.array([1.0, facing])
    core = np.array([0.02, 0.015]) - 0.005

    def distance(angles, place):
        reach = (place,) if phalanx % 2 == 0 else (lengths[mcp], place)
        turns = np.cumsum([angles[mcp], angles[pip]])
        point = sum(
            r * np.array([np.cos(a), -np.sin(a)])
            for r, a in zip(reach, turns[: len(reach)], strict=True)
        )
        over = np.abs(point - centre) - core
        if over.max() < 0.0:  # in the core the sides blend: see signed_distance
            return -(((-over) ** -8.0).sum() ** (-1.0 / 8.0))
        return np.linalg.norm(np.maximum(over, 0.0))

    for angles, speeds in moving():
        found = touch(angles, speeds)
        place = found("place")[phalanx]
        after, before = (distance(angles + sign * step * speeds, place) for sign in (1.0, -1.0))
        expected = (before - after) / (2.0 * step)
        assert found("penetration_rate")[phalanx] == pytest.approx(expected, rel=1e-4, abs=1e-8)
        depth = 0.008 + 0.005 - distance(angles, place)
        assert found("penetration")[phalanx] == pytest.approx(depth, abs=1e-12)


@pytest.mark.parametrize("shape", SECTIONS)
@pytest.mark.parametrize("phalanx", range(10))
def test_lever_arms_are_the_jacobian_of_the_touching_point(shape, phalanx):
    touch, f, step = Touch(shape, SECTIONS[shape]), phalanx // 2, 1e-6
    bench = touch.bench
    lengths = bench.p[bench.compiled.parameters["link_length"]]
    radius = bench.p[bench.compiled.parameters["phalanx_radius"]][phalanx]
    for angles in poses():
        found = touch(angles)
        normal = np.array([found("normal_x")[phalanx], found("normal_y")[phalanx]])
        along = found("place")[phalanx]

        def skin(q, fixed):
            """Point of the phalanx's skin, rigidly carried along."""
            sum_of = q[2 * f] + q[2 * f + 1]
            turn = sum_of if phalanx % 2 else q[2 * f]
            start = lengths[2 * f] * np.array([np.cos(q[2 * f]), -np.sin(q[2 * f])])
            start = start if phalanx % 2 else np.zeros(2)
            ahead = np.array([np.cos(turn), -np.sin(turn)])
            across = np.array([ahead[1], -ahead[0]])
            return start + fixed[0] * ahead + fixed[1] * across

        q1, q2 = angles[2 * f], angles[2 * f + 1]
        turn = q1 + q2 if phalanx % 2 else q1
        ahead = np.array([np.cos(turn), -np.sin(turn)])
        across = np.array([ahead[1], -ahead[0]])
        fixed = np.array([along - radius * normal @ ahead, -radius * normal @ across])
        tangent = np.array([-normal[1], normal[0]])
        for joint in range(2):
            moved = np.zeros(10)
            moved[2 * f + joint] = step
            slope = (skin(angles + moved, fixed) - skin(angles - moved, fixed)) / (2 * step)
            about = ("mcp", "pip")[joint]
            arms = [found(f"{kind}_arm_{about}")[phalanx] for kind in ("normal", "slip")]
            assert arms == pytest.approx([slope @ normal, slope @ tangent], abs=1e-9)


def test_the_thumb_mirrors_a_finger():
    """The same finger facing the other way meets a mirrored object with the same depth."""
    same = {"first_length": 0.03, "second_length": 0.04, "third_length": 0.036}
    values = {f"{f}.{k}": v for f in ("index", "thumb") for k, v in same.items()}
    touch = Touch("cylinder", values | {"object.x": 0.02, "object.y": -0.0445})
    angles = np.tile([0.7, 0.6], 5)
    for link in range(2):
        index, thumb = touch(angles), touch(angles)
        mine, theirs = index("penetration")[link], thumb("penetration")[8 + link]
        assert mine == pytest.approx(theirs, abs=1e-15)
        assert index("normal_x")[link] == pytest.approx(thumb("normal_x")[8 + link])
