"""The hand's own equations in MuJoCo: its bodies and integrators, our forces in a callback.

MuJoCo has the rods on hinges, the carts on slides, the rotor, and the winding as a slide whose
mass is the inductance and whose speed is the current; the controller's four states are its
activations. All forces come from the hand's compiled stages, called by MuJoCo as C functions.

`linearised` is an expert's help that MuJoCo does not ask for. The callback also writes how
steeply the force on each joint falls with that joint's own speed, as joint damping, which
MuJoCo treats implicitly, and adds as much to the force again: the equations stay the same.
"""

import functools
import math
from types import ModuleType
from typing import Any

import mujoco
import numba
import numpy as np
from numba import carray

from benchmarks.mujoco.engine import (
    ACT,
    ACT_DOT,
    DOF_DAMPING,
    DYNAMICS,
    GENERIC,
    QFRC_PASSIVE,
    QPOS,
    QVEL,
    TIME,
    USERDATA,
    Launch,
    as_numbers,
)
from hannes.control.firmware_memory import MEMORY
from hannes.core.kernels.smooth_switches import smoothstep
from hannes.core.layout import Layout
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.anatomy import FINGERS
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.mjcf_bodies import skeleton
from hannes.simulation.hand.variables import CHANNELS, LANES, PARAMETER_SLOTS, STATES

Y, C, P = Layout(STATES), Layout(CHANNELS), Layout(PARAMETER_SLOTS)


def places(*names: str) -> np.ndarray:
    """Where states lie in the hand's own array, in the order of `names`."""
    return np.concatenate([np.arange(Y.size)[Y[name]] for name in names])


ANGLES = places("motor_angle", "cart_position", "joint_angle")  # as MuJoCo orders its joints
SPEEDS = places("motor_speed", "cart_speed", "joint_speed", "motor_current")
CONTROLLER = places("position_integral", "position_lag", "current_integral", "current_lag")
NV, NA = SPEEDS.size, CONTROLLER.size  # the winding's charge has a place but no meaning
FREE = np.array([0, 1, 2, NV - 1])  # all but the hinges: their force is inertia times rate
KNOTS = 3
# Rows of mjData.userdata: inertias, dampings, what the stages read, and room for them to work.
SIZES = (1, NV, NV, P.size, 2 * KNOTS, MEMORY, C.size, Y.size, Y.size)
HELP, INERTIA, STEEP, VALUES, REFERENCE, HELD, CHANNEL, STATE, RATE = range(len(SIZES))
BOUNDS = np.cumsum((0, *SIZES))
USER = int(BOUNDS[-1])
TORQUE, PUSH, DEPTH, SLIP, NORMAL_ARM, SLIP_ARM = (
    C[name].start
    for name in (
        *("joint_torque", "normal_force", "penetration", "slip_speed"),
        *("normal_arm_mcp", "slip_arm_mcp"),
    )
)
PRESENT, DAMPING, ONSET, FRICTION, WIDTH = (
    P[f"object_{name}"].start for name in ("present", "damping", "onset", "friction", "slip_speed")
)


def model(hand: Hand, integrator: str, linearised: bool = False) -> mujoco.MjModel:
    """MuJoCo's model of bodies alone; damped joints, where the callback shall set dampings."""
    value = hand.parameters
    winding = (
        '<body><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" '
        f'mass="{value["motor.inductance"]}" diaginertia="1e-6 1e-6 1e-6"/></body>'
    )
    found = mujoco.MjModel.from_xml_string(f"""
        <mujoco><compiler angle="radian"/><size nuserdata="{USER}"/>
        <option integrator="{integrator}"><flag contact="disable" constraint="disable"
        gravity="disable" spring="disable" sensor="disable" warmstart="disable"
        autoreset="disable"/></option>
        <worldbody>{skeleton(value)}{winding}</worldbody>
        <actuator><general joint="motor" dyntype="user" actdim="{NA}" gainprm="0"
        biastype="none"/></actuator></mujoco>""")
    found.dof_damping[:] = 1e-9 if linearised else 0.0
    return found


@numba.njit
def part(user, row):
    """One row of userdata."""
    return user[BOUNDS[row] : BOUNDS[row + 1]]


@numba.njit(error_model="numpy")
def steepen(user, v, damping, force):
    """Hand MuJoCo how steeply forces fall with speed: at wires and winding, and at contacts."""
    p, c = part(user, VALUES), part(user, CHANNEL)
    for k in range(NV):
        force[k] += damping[k] * v[k]  # what MuJoCo took with the damping of the last step
        damping[k] = part(user, STEEP)[k]
    for k in range(10):
        if c[PUSH + k] > 0.0:
            normal = p[DAMPING] * smoothstep(c[DEPTH + k] / p[ONSET])
            grip = math.tanh(c[SLIP + k] / p[WIDTH])
            slip = p[FRICTION] * c[PUSH + k] * (1.0 - grip**2) / p[WIDTH]
            for joint in range(2):
                arms = c[NORMAL_ARM + LANES * joint + k], c[SLIP_ARM + LANES * joint + k]
                damping[3 + k - k % 2 + joint] += normal * arms[0] ** 2 + slip * arms[1] ** 2


@functools.cache
def callbacks(fast: ModuleType) -> dict[str, Any]:
    """`mjcb_passive` and `mjcb_act_dyn` around the compiled stages of a hand."""
    position_reference, sense, control, drive = (
        *(fast.position_reference, fast.sense),
        *(fast.control, fast.drive),
    )
    kinematics, leader, gear, carts = fast.kinematics, fast.leader, fast.gear, fast.carts
    joints, contact = fast.joints, fast.contact

    @numba.njit(error_model="numpy")
    def stages(t, user):
        y, dy, p, c = part(user, STATE), part(user, RATE), part(user, VALUES), part(user, CHANNEL)
        reference, memory = part(user, REFERENCE).reshape((2, KNOTS)), part(user, HELD)
        target = position_reference(t, y, dy, p, c, reference, dy)
        position, current = sense(t, y, dy, p, c, memory, dy)
        duty = control(t, y, dy, p, c, memory, target, position, current, dy)
        torque_constant = drive(t, y, dy, p, c, duty, dy)
        kinematics(y, p, c)
        load = leader(t, y, dy, p, c, dy)
        gear(t, y, dy, p, c, torque_constant, load, dy)
        carts(t, y, dy, p, c, dy)
        joints(t, y, dy, p, c, dy)
        if p[PRESENT] > 0.5:
            contact(t, y, dy, p, c, dy)

    @numba.njit(error_model="numpy")
    def forces(t, q, v, act, user, force):
        y, dy, c = part(user, STATE), part(user, RATE), part(user, CHANNEL)
        for k in range(ANGLES.size):
            y[ANGLES[k]] = q[k]
        for k in range(NV):
            y[SPEEDS[k]] = v[k]
        for k in range(NA):
            y[CONTROLLER[k]] = act[k]
        stages(t, user)
        for k in FREE:
            force[k] += part(user, INERTIA)[k] * dy[SPEEDS[k]]
        for k in range(10):
            force[3 + k] += c[TORQUE + k]

    @numba.cfunc(GENERIC)
    def passive(m, d):
        user, v, force = carray(d[USERDATA], USER), carray(d[QVEL], NV), carray(d[QFRC_PASSIVE], NV)
        forces(as_numbers(d)[TIME], carray(d[QPOS], NV), v, carray(d[ACT], NA), user, force)
        if part(user, HELP)[0] > 0.5:
            steepen(user, v, carray(m[DOF_DAMPING], NV), force)

    @numba.cfunc(DYNAMICS)
    def act_dyn(m, d, actuator):
        change, rate = carray(d[ACT_DOT], NA), part(carray(d[USERDATA], USER), RATE)
        for k in range(NA):
            change[k] = rate[CONTROLLER[k]]
        return change[NA - 1]

    return {"passive": passive, "act_dyn": act_dyn}


def steepness(hand: Hand) -> np.ndarray:
    """Fall of each force with its own speed at taut wires, free joints, unsaturated winding."""
    value = hand.parameters
    leader, follower = value["leader.damping"], value["follower.damping"]
    arm = value["gear.pulley_radius"] / value["gear.ratio"]
    cart = 4.0 * (leader + follower) + value["cart.viscous_friction"]
    found = [leader * arm**2 + value["motor.viscous_friction"], cart, cart]
    for finger in FINGERS:
        wire = leader if finger == "thumb" else follower
        found += [
            wire * value[f"{joint}.moment_arm"] ** 2 + value[f"{joint}.viscous_friction"]
            for joint in ("mcp", "pip")
        ]
    found += [value["motor.resistance"] + value["current_pid.proportional"]]
    return np.array(found)


def launch(
    hand: Hand, experiment: Experiment, integrator: str, every: int, linearised: bool = False
) -> Launch:
    """The experiment with our equations, `every` steps between two samples."""
    posed = hand.with_values(experiment.overrides())
    compiled, value = posed.compiled(()), posed.parameters
    inertia = np.zeros(NV)
    inertia[FREE] = [
        value[name] for name in ("motor.inertia", "cart.mass", "cart.mass", "motor.inductance")
    ]
    rows = (
        *([float(linearised)], inertia, steepness(posed)),
        *(posed.vector(experiment.shape, ()), experiment.reference.knots, np.zeros(MEMORY)),
    )
    userdata = np.zeros(USER)
    userdata[: BOUNDS[CHANNEL]] = np.concatenate([np.ravel(row) for row in rows])
    m = model(posed, integrator, linearised)
    m.opt.timestep = 1.0 / (experiment.sampling * every)
    angles = posed.rest(compiled)[Y["joint_angle"]]
    return Launch(m, callbacks(compiled.fast), userdata, angles, experiment.times.size, every)


def states(rows: np.ndarray) -> np.ndarray:
    """MuJoCo's samples as states of the hand, shape (samples, states)."""
    found = np.empty((rows.shape[0], Y.size))
    found[:, ANGLES] = rows[:, : ANGLES.size]
    found[:, SPEEDS], found[:, CONTROLLER] = rows[:, NV : 2 * NV], rows[:, 2 * NV :]
    return found
