"""Outside the catalogue: friction that jumps at one angle of one joint (a burr, a worn bush).

    T_friction += torque (1 + tanh((q - angle) / 0.02 rad)) / 2 tanh(q' / (w_bf / 10))

joint: 2 finger + (0 MCP, 1 PIP), fingers from index 0 to thumb 4. Source: position-dependent
friction, Armstrong & Canudas de Wit (1995). Range: 2 to 60 mN m (MCP's Coulomb friction is 10.7).
"""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "torque": Size("N m", 2e-3, 60e-3),
    "angle": Size("rad", 0.3, 1.2, default=0.5, amplitude=False),
    "joint": Size("1", 0.0, 9.0, default=2.0, amplitude=False),
}


@compiled
def drag(h, joint, angle, speed, breakaway_speed):
    """Torque (N m) that opposes the joint."""
    if h.friction_step_torque == 0.0 or joint != h.friction_step_joint:
        return 0.0
    there = 0.5 * (1.0 + tanh((angle - h.friction_step_angle) / 0.02))
    return h.friction_step_torque * there * tanh(speed / (0.1 * breakaway_speed))
