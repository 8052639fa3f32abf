"""Outside the catalogue: MCP joints that catch at one angle (a dented bush, a seam of a print).

    T_open += torque sqrt(e) u exp(-u^2 / 2),  u = (q - angle) / width,  at all five MCP joints

The notch holds a joint in it from both sides, at most by `torque`, one width off its middle. It
gives back on the way out what it took on the way in. Source: force of a spring plunger, whose
potential is a well. Range: 5 mN m (a scratch) to 80 mN m (a detent), a sixth of the return
spring's preload to three times as much.
"""

from math import exp, sqrt

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "torque": Size("N m", 5e-3, 80e-3),
    "angle": Size("rad", 0.35, 0.7, default=0.45, amplitude=False),
    "width": Size("rad", 0.03, 0.12, default=0.06, amplitude=False),
}


@compiled
def joint_torque(h, joint, angle, speed):
    """Torque (N m) that opens the joint."""
    if h.notched_joint_torque == 0.0 or joint % 2 == 1:
        return 0.0
    u = (angle - h.notched_joint_angle) / h.notched_joint_width
    return h.notched_joint_torque * sqrt(exp(1.0)) * u * exp(-0.5 * u * u)
