"""The model that `hannes hand --mjcf` prints, driven through a motor's angle over time."""

import mujoco
import numpy as np

from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.mjcf import mjcf


def driven(hand: Hand, time: np.ndarray, angle: np.ndarray) -> dict[str, np.ndarray]:
    """Motor torque [N m], leader tension [N] as the motor follows `angle` [rad] over `time` [s]."""
    model = mujoco.MjModel.from_xml_string(mjcf(hand))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    steps = np.arange(round(float(time[-1]) / model.opt.timestep) + 1) * model.opt.timestep
    rows = np.empty((steps.size, model.nsensordata))
    for k, target in enumerate(np.interp(steps, time, angle)):
        data.ctrl[0] = target
        mujoco.mj_step(model, data)
        rows[k] = data.sensordata
    torque, length, rate = (np.interp(time, steps, column) for column in rows.T)
    stretch = length - model.tendon_lengthspring[model.tendon("leader").id, 1]
    value = hand.parameters
    tension = value["leader.stiffness"] * stretch + value["leader.damping"] * rate
    return {"motor torque": torque, "leader tension": np.where(stretch > 0.0, tension, 0.0)}
