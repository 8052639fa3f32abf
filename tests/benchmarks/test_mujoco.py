"""The same hand in MuJoCo: its kinematics, inertia, Coriolis forces, gravity and integrator.

Two runs: the whole dynamometer grasp as it ships, and a short closing that meets what it does not.

MuJoCo carries rods on hinges, carts on slides and a rotor; wires, springs, stops, friction and
contact are written here a second time, in the world frame, as forces on its joints. The winding
and the controller are activations that MuJoCo integrates along.
"""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from runs import reference, worst

from hannes.core.kernels.jit import kernel
from hannes.simulation.experiment.experiment import Experiment, Target
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.simulate import simulate

mujoco = pytest.importorskip("mujoco")

STEP, EVERY = 8e-6, 250
RAMP = ((0.0, 0.0), (1.0, 15.5))
VALUES = {
    "gravity.x": 3.0,
    "gravity.y": -9.0,
    "gravity.z": -2.0,
    "little.end_mcp": 0.28,  # this finger meets its stop on the way
    "object.radius": 0.029,
    "object.friction": 0.3,
    "position_pid.integral": 0.5,
    "current_pid.derivative": 1e-5,
}


def rod(name, length, mass, axis, start, inside=""):
    """Body of a uniform rod along x on a hinge at its start."""
    turning = mass * length**2 / 12.0
    return (
        f'<body pos="{start} 0 0"><joint name="{name}" type="hinge" axis="0 0 {axis}"/>'
        f'<inertial pos="{length / 2} 0 0" mass="{mass}" '
        f'diaginertia="1e-15 {turning} {turning}"/>{inside}</body>'
    )


def model(value):
    """MuJoCo's model: rotor, carts A and B, then MCP and PIP of each finger."""
    turning = value("motor.inertia")
    bodies = [
        '<body><joint name="motor" type="hinge" axis="0 0 1"/><inertial pos="0 0 0" mass="1e-3" '
        f'diaginertia="{turning} {turning} {turning}"/></body>'
    ]
    bodies += [
        '<body gravcomp="1"><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" '
        f'mass="{value("cart.mass")}" diaginertia="1e-6 1e-6 1e-6"/></body>'
    ] * 2
    for f in FINGERS:
        axis = -value(f"{f}.facing")
        second, third = value(f"{f}.second_length"), value(f"{f}.third_length")
        tip = rod(f"{f}_pip", third, value(f"{f}.third_mass"), axis, second)
        base = rod(f"{f}_mcp", second, value(f"{f}.second_mass"), axis, 0, tip)
        place = " ".join(str(value(f"{f}.mount_{x}")) for x in "xyz")
        bodies.append(f'<body pos="{place}">{base}</body>')
    gravity = " ".join(str(value(f"gravity.{x}")) for x in "xyz")
    return mujoco.MjModel.from_xml_string(f"""
        <mujoco><compiler angle="radian"/>
        <option timestep="{STEP}" integrator="RK4" gravity="{gravity}">
        <flag contact="disable" constraint="disable"/></option>
        <worldbody>{"".join(bodies)}</worldbody>
        <actuator><general joint="motor" dyntype="user" actdim="5" biastype="none"
        gainprm="{value("motor.torque_constant")}"/></actuator></mujoco>""")


@kernel
def smooth(x):
    """3 x^2 - 2 x^3 between 0 and 1."""
    x = min(max(x, 0.0), 1.0)
    return 3.0 * x**2 - 2.0 * x**3


@kernel
def unilateral(k, c, depth, rate, onset):
    """Spring and damper, only pushing."""
    return max(0.0, k * depth + c * rate * smooth(depth / onset)) if depth > 0.0 else 0.0


@kernel
def rub(w, level):
    """Eq. 1 and 2: level holds T_bf, T_cf, w_bf, f."""
    x = w / level[2]
    peak = math.sqrt(math.e) * (level[0] - level[1]) * x * math.exp(-0.5 * x**2)
    return peak + level[1] * math.tanh(10.0 * x) + level[3] * w


@kernel
def clip(x, limit):
    """Clip with corners rounded by parabolas over 2 % on either side."""
    size, width = abs(x), 0.02 * limit
    if size > limit + width:
        size = limit
    elif size > limit - width:
        size -= (size - limit + width) ** 2 / (4.0 * width)
    return math.copysign(size, x)


@kernel
def grip(q, v, anchors, k, force):
    """Contact of every phalanx with the cylinder, in the world frame; adds J^T F to `force`."""
    total = 0.0
    for f in range(5):
        hub, sign = 3 + 2 * f, -k.facing[f]  # rotation about z
        angle = 0.0
        for link in range(2):
            angle += sign * q[hub + link]
            ax, ay = math.cos(angle), math.sin(angle)
            ox, oy = k.centre[0] - anchors[hub + link, 0], k.centre[1] - anchors[hub + link, 1]
            along = min(max(ox * ax + oy * ay, 0.0), k.lengths[f, link])
            nx, ny = along * ax - ox, along * ay - oy
            gap = math.hypot(nx, ny)
            nx, ny = nx / gap, ny / gap
            px, py = anchors[hub + link, 0] + along * ax, anchors[hub + link, 1] + along * ay
            px, py = px - k.finger_radius[f] * nx, py - k.finger_radius[f] * ny
            vx, vy = 0.0, 0.0
            for joint in range(link + 1):
                w = sign * v[hub + joint]
                vx -= w * (py - anchors[hub + joint, 1])
                vy += w * (px - anchors[hub + joint, 0])
            depth = k.finger_radius[f] + k.radius - gap
            push = unilateral(k.push[0], k.push[1], depth, -(vx * nx + vy * ny), k.push[2])
            slip = vy * nx - vx * ny
            drag = k.grip[0] * push * math.tanh(slip / k.grip[1])
            fx, fy = push * nx + drag * ny, push * ny - drag * nx
            for joint in range(link + 1):
                rx, ry = px - anchors[hub + joint, 0], py - anchors[hub + joint, 1]
                force[hub + joint] += sign * (rx * fy - ry * fx)
            total += push
    return total


@kernel
def asked_angle(time, times, angles):
    """The reference: straight lines through its knots, the last angle after them."""
    for j in range(times.size - 1):
        if time < times[j + 1]:
            slope = (angles[j + 1] - angles[j]) / (times[j + 1] - times[j])
            return angles[j] + slope * (time - times[j])
    return angles[-1]


@kernel
def forces(time, q, v, act, anchors, k, force, rate, seen):
    """Forces on all joints but inertia, gravity and motor torque; rates of the activations."""
    error = asked_angle(time, k.times, k.angles) * k.ratio - q[0]
    speed = (q[0] - act[1]) / k.outer[3]
    wanted = k.outer[0] * error + act[0] - k.outer[2] * speed
    asked = clip(wanted, k.outer[4])
    rate[0] = k.outer[1] * (error + (asked - wanted) / k.outer[0])
    rate[1] = speed
    current = act[4]
    rise = (current - act[3]) / k.inner[3]
    wanted = k.inner[0] * (asked - current) + act[2] - k.inner[2] * rise
    given = clip(wanted, k.inner[4])
    rate[2] = k.inner[1] * (asked - current + (given - wanted) / k.inner[0])
    rate[3] = rise
    rate[4] = (given - k.motor[0] * current - k.motor[1] * v[0]) / k.motor[2]
    wire, pace = np.zeros(5), np.zeros(5)
    for f in range(5):
        for j in range(2):
            wire[f] += k.arms[j] * (q[3 + 2 * f + j] - k.rest[f, j])
            pace[f] += k.arms[j] * v[3 + 2 * f + j]
    arm = k.pulley / k.ratio
    stretch = arm * q[0] - 2.0 * (q[1] + q[2]) - wire[4]
    leader = unilateral(
        k.leader[0], k.leader[1], stretch, arm * v[0] - 2.0 * (v[1] + v[2]) - pace[4], k.leader[2]
    )
    force[0] = -arm * leader - k.motor[3] * math.tanh(v[0] / k.motor[4]) - k.motor[5] * v[0]
    pulls = np.full(5, leader)
    for cart in range(2):
        pull = unilateral(
            k.follower[0],
            k.follower[1],
            2.0 * q[1 + cart] - wire[2 * cart] - wire[2 * cart + 1],
            2.0 * v[1 + cart] - pace[2 * cart] - pace[2 * cart + 1],
            k.follower[2],
        )
        pulls[2 * cart : 2 * cart + 2] = pull
        force[1 + cart] = 2.0 * (leader - pull) - rub(v[1 + cart], k.rub[2])
    for f in range(5):
        for j in range(2):
            at = 3 + 2 * f + j
            past = q[at] - k.rest[f, j]
            spring = k.spring[j, 1] + k.spring[j, 0] * past
            low = k.spring[j, 1] / k.stop[j, 0] - past
            stop = unilateral(k.stop[j, 0], k.stop[j, 1], low, -v[at], k.stop[j, 2])
            high = q[at] - k.end[f, j]
            stop -= unilateral(k.stop[j, 0], k.stop[j, 1], high, v[at], k.stop[j, 2])
            force[at] = k.arms[j] * pulls[f] - spring - rub(v[at], k.rub[j]) + stop
    seen[0], seen[1], seen[2] = current, grip(q, v, anchors, k, force), leader
    seen[3] = given


def constants(value, knots):
    """Everything `forces` needs, by name, as a named tuple of arrays and numbers."""
    from collections import namedtuple

    def row(*names):
        return np.array([value(name) for name in names])

    def each(pattern, second):
        return np.array([[value(pattern.format(f, s)) for s in second] for f in FINGERS])

    def levels(place):
        return row(
            *(
                f"{place}.{name}"
                for name in (
                    "breakaway_friction",
                    "coulomb_friction",
                    "breakaway_speed",
                    "viscous_friction",
                )
            )
        )

    pair = ("mcp", "pip")
    motor = "resistance torque_constant inductance dry_friction friction_speed viscous_friction"
    found = {
        "times": knots[0],
        "angles": knots[1],
        "ratio": value("gear.ratio"),
        "pulley": value("gear.pulley_radius"),
        "outer": row(*(f"position_pid.{n}" for n in PID), "position_pid.limit"),
        "inner": row(*(f"current_pid.{n}" for n in PID), "supply.voltage"),
        "motor": row(*(f"motor.{name}" for name in motor.split())),
        "leader": row("leader.stiffness", "leader.damping", "wires.onset"),
        "follower": row("follower.stiffness", "follower.damping", "wires.onset"),
        "arms": row(*(f"{j}.moment_arm" for j in pair)),
        "rest": each("{}.rest_{}", pair),
        "end": each("{}.end_{}", pair),
        "lengths": each("{}.{}_length", ("second", "third")),
        "spring": np.array([row(f"{j}.spring_stiffness", f"{j}.spring_preload") for j in pair]),
        "stop": np.array(
            [row(*(f"{j}.stop_{n}" for n in ("stiffness", "damping", "onset"))) for j in pair]
        ),
        "rub": np.array([levels(place) for place in (*pair, "cart")]),
        "facing": row(*(f"{f}.facing" for f in FINGERS)),
        "finger_radius": row(*(f"{f}.radius" for f in FINGERS)),
        "centre": row("object.x", "object.y"),
        "radius": value("object.radius"),
        "push": row("object.stiffness", "object.damping", "object.onset"),
        "grip": row("object.friction", "object.slip_speed"),
    }
    return namedtuple("Constants", found)(**found)


PID = ("proportional", "integral", "derivative", "filter")


def grasp():
    """The paper's dynamometer grasp as it ships: closing, squeezing, opening."""
    (variant,) = load_experiment("dynamometer")
    return replace(variant.experiment, sampling=1.0 / (STEP * EVERY), noise={})


def everything():
    """A shorter closing that meets gravity, a stop, and terms of the controller that are off."""
    return Experiment(
        "beside MuJoCo",
        0.36,
        reference(RAMP),
        Target("cylinder"),
        sampling=1.0 / (STEP * EVERY),
        values=VALUES,
    )


CASES = {"grasp": grasp, "everything": everything}
# The whole grasp takes ten seconds; what it meets, the short one and benchmarks/truth meet too.
LONG = [pytest.param("grasp", marks=pytest.mark.slow), "everything"]


@functools.cache
def carried(case):
    """Samples of MuJoCo's run: current, force, leader tension, voltage, joints."""
    experiment = CASES[case]()
    value = Hand().with_values(experiment.overrides()).parameters.__getitem__
    m, k = model(value), constants(value, experiment.reference.knots)
    d = mujoco.MjData(m)
    d.qpos[3:] = k.rest.ravel()
    rate, seen = np.zeros(5), np.zeros(4)
    force = np.zeros(13)
    q, v, act, anchors, passive = d.qpos, d.qvel, d.act, d.xanchor, d.qfrc_passive
    act_dot = d.act_dot

    def push(_, data):
        forces(data.time, q, v, act, anchors, k, force, rate, seen)
        passive[:] += force

    def wind(_, data, actuator):
        act_dot[:] = rate
        return rate[4]

    rows = []
    mujoco.set_mjcb_passive(push)
    mujoco.set_mjcb_act_dyn(wind)
    try:
        for _ in experiment.times:
            mujoco.mj_forward(m, d)
            rows.append(np.concatenate([seen, d.qpos, d.qvel]))
            mujoco.mj_step(m, d, EVERY)
    finally:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mjcb_act_dyn(None)
    return np.array(rows)


@functools.cache
def ours(case):
    """The library's run of the same experiment."""
    return simulate(Hand(), CASES[case](), rtol=1e-10).require()


TRACES = ("current", "force", "leader_tension")
STATES = {  # columns of `carried`
    "motor_angle": slice(4, 5),
    "cart_position": slice(5, 7),
    "joint_angle": slice(7, 17),
    "motor_speed": slice(17, 18),
    "cart_speed": slice(18, 20),
    "joint_speed": slice(20, 30),
}


def test_the_short_experiment_meets_everything():
    """Free closing, touch of four fingers, a stop: else the agreement would say little."""
    run = ours("everything")
    assert (run["phalanx_force"].max(axis=0).reshape(5, 2)[[0, 1, 2, 4]] > 1.0).all()
    assert run["joint_angle"][:, 6].max() > VALUES["little.end_mcp"]


@pytest.mark.slow
def test_the_grasp_is_the_whole_of_it():
    """It closes, squeezes with every finger, lets go, and is open at the end."""
    run = ours("grasp")
    force = run["force"]
    assert force.max() > 150.0 and force[0] == force[-1] == 0.0
    assert (run["phalanx_force"].max(axis=0).reshape(5, 2).max(axis=1) > 1.0).all()
    assert run["position"].max() > 5.0 and run["position"][-1] < 0.1 * run["position"].max()


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("column, name", list(enumerate(TRACES)))
def test_traces_agree_with_mujoco(case, column, name):
    assert worst(carried(case)[:, column], ours(case)[name]) < 1e-6


@pytest.mark.parametrize("case", LONG)
@pytest.mark.parametrize("name", STATES)
def test_states_agree_with_mujoco(case, name):
    theirs = carried(case)[:, STATES[name]]
    mine = ours(case)[name].reshape(theirs.shape)
    for column in range(theirs.shape[1]):
        assert worst(theirs[:, column], mine[:, column]) < 1e-5
