"""The hand in MuJoCo's own elements, run with both PIDs in a compiled control callback.

It is another model than ours (elements.py), so its errors are against its own limit at fine
steps; how far that limit lies from the hand's own equations is a row of its own.
"""

import functools
from types import ModuleType
from typing import Any

import numba
import numpy as np
from numba import carray

from benchmarks.mujoco.elements import STATES, Idiom, model
from benchmarks.mujoco.engine import (
    ACT,
    ACT_DOT,
    CTRL,
    DOF_FRICTIONLOSS,
    DYNAMICS,
    GENERIC,
    QPOS,
    QVEL,
    TIME,
    USERDATA,
    Launch,
    as_numbers,
)
from benchmarks.mujoco.same import CONTROLLER, KNOTS, MEMORY, P, Y, places
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.hand.hand import Hand

SIZES = (P.size, 2 * KNOTS, MEMORY, Y.size, Y.size, 2)
VALUES, REFERENCE, HELD, STATE, RATE, LOAD = range(len(SIZES))
BOUNDS = np.cumsum((0, *SIZES))
USER = int(BOUNDS[-1])
MOTOR = places("motor_angle", "motor_speed", "motor_current")
SUPPLY = P["supply_voltage"].start


@numba.njit
def part(user, row):
    """One row of userdata."""
    return user[BOUNDS[row] : BOUNDS[row + 1]]


@functools.cache
def callbacks(fast: ModuleType, loaded: bool = False) -> dict[str, Any]:
    """`mjcb_control` and `mjcb_act_dyn` around the hand's own controller.

    loaded: the motor's `frictionloss` grows with its torque, by row LOAD of userdata: level without
    a load [N m], and N m per ampere.
    """
    position_reference, sense, pids = fast.position_reference, fast.sense, fast.control

    @numba.njit(error_model="numpy")
    def voltage(t, user):
        y, dy, p = part(user, STATE), part(user, RATE), part(user, VALUES)
        reference, memory = part(user, REFERENCE).reshape((2, KNOTS)), part(user, HELD)
        target = position_reference(t, y, dy, p, y, reference, dy)
        position, current = sense(t, y, dy, p, y, memory, dy)
        return pids(t, y, dy, p, y, memory, target, position, current, dy) * p[SUPPLY]

    @numba.cfunc(GENERIC)
    def control(m, d):
        user, act = carray(d[USERDATA], USER), d[ACT]
        y = part(user, STATE)
        y[MOTOR[0]], y[MOTOR[1]], y[MOTOR[2]] = d[QPOS][0], d[QVEL][0], act[0]
        for k in range(STATES):
            y[CONTROLLER[k]] = act[1 + k]
        carray(d[CTRL], 1)[0] = voltage(as_numbers(d)[TIME], user)
        if loaded:
            level, more = part(user, LOAD)
            carray(m[DOF_FRICTIONLOSS], 1)[0] = level + more * abs(act[0])

    @numba.cfunc(DYNAMICS)
    def act_dyn(m, d, actuator):
        change, rate = carray(d[ACT_DOT], 1 + STATES), part(carray(d[USERDATA], USER), RATE)
        for k in range(STATES):
            change[1 + k] = rate[CONTROLLER[k]]
        return change[STATES]

    return {"control": control, "act_dyn": act_dyn}


def launch(
    hand: Hand,
    experiment: Experiment,
    idiom: Idiom,
    integrator: str,
    every: int,
    load: float = 0.0,
) -> Launch:
    """The experiment in MuJoCo's own elements, `every` steps between two samples.

    load: share of the motor's torque by which its dry friction grows
    """
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled(())
    rows = (posed.vector(experiment.shape, ()), experiment.reference.knots, np.zeros(MEMORY))
    userdata = np.zeros(USER)
    userdata[: BOUNDS[STATE]] = np.concatenate([np.ravel(row) for row in rows])
    value = posed.parameters
    more = load * value["motor.torque_constant"]
    userdata[BOUNDS[LOAD] : BOUNDS[LOAD + 1]] = value["motor.dry_friction"], more
    m = model(posed, idiom, integrator, USER, experiment.object is not None)
    m.opt.timestep = 1.0 / (experiment.sampling * every)
    angles = posed.rest(compiled)[Y["joint_angle"]]
    called = callbacks(compiled.fast, load > 0.0)
    return Launch(m, called, userdata, angles, experiment.times.size, every)


def traces(run: Launch, hand: Hand) -> dict[str, np.ndarray]:
    """Current [A], sum of contact forces [N] and leader tension [N] at the sample times; the
    motor's angle [rad] beside them.

    The tension is that of the wire's law at its stretch and rate.
    """
    rows, readings = run.sensed()
    force, length, rate = readings.T
    m, value = run.model, hand.parameters
    wire = m.tendon("leader").id
    free = m.tendon_range if m.tendon_limited[wire] else m.tendon_lengthspring
    stretch = length - free[wire, 1]
    tension = value["leader.stiffness"] * stretch + value["leader.damping"] * rate
    return {
        "current": rows[:, m.nq + m.nv],
        "motor_angle": rows[:, 0],
        "force": force,
        "leader_tension": np.where(stretch > 0.0, tension, 0.0),
    }
