"""Outside the catalogue: a motor pulley whose centre is off its shaft.

    wound = r_p (phi + share (sin(phi + phase) - sin(phase))),  r = r_p (1 + share cos(phi + phase))

phi: output-shaft angle; r: lever of the wire, so that power is conserved. Source: geometry. Range:
1 % to 15 % of the radius.
"""

from math import cos, sin

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "share": Size("1", 0.01, 0.15),
    "phase": Size("rad", -3.2, 3.2, amplitude=False),
}


@compiled
def wound(h, angle):
    """Wire wound up (m) at the output shaft's angle (rad), and the wire's lever (m)."""
    share, phase = h.eccentric_pulley_share, h.eccentric_pulley_phase
    turned = angle
    lever = h.gear_pulley_radius
    if share != 0.0:
        turned += share * (sin(angle + phase) - sin(phase))
        lever *= 1.0 + share * cos(angle + phase)
    return h.gear_pulley_radius * turned, lever
