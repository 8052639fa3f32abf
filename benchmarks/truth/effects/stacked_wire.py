"""Outside the catalogue: a leader that climbs onto its own turns on the motor pulley.

    r = r_p (1 + share s(u)),  s = u^2 (3 - 2 u) for u from 0 to 1,  u = (phi - from) / 0.4 rad

phi: output-shaft angle; the wire wound up is r_p times the integral of that, so that power is
conserved. Source: geometry of a drum's second layer. Range: a wire of 0.15 mm (3 %) to one of 1 mm
(20 %) on 4.7 mm; the pulley has room for 1.5 to 5.5 rad.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "share": Size("1", 0.03, 0.2),
    "from": Size("rad", 1.5, 5.5, default=3.0, amplitude=False),
}
CLIMB = 0.4  # rad


@compiled
def further(h, angle):
    """Further wire wound up (m) at the output shaft's angle (rad), and further lever (m)."""
    u = (angle - h.stacked_wire_from) / CLIMB
    if h.stacked_wire_share == 0.0 or u <= 0.0:
        return 0.0, 0.0
    more = h.stacked_wire_share * h.gear_pulley_radius
    if u >= 1.0:
        return more * CLIMB * (u - 0.5), more
    return more * CLIMB * u * u * u * (1.0 - 0.5 * u), more * u * u * (3.0 - 2.0 * u)
