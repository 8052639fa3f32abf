"""Outside the catalogue: return springs that stiffen as they wind up.

    T_open += cubic (q - q_rest)^3   at all ten joints

Source: Duffing (1918). Range: 3 to 80 mN m/rad3 (the linear rate is about 23 mN m/rad).
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"cubic": Size("N m/rad^3", 3e-3, 80e-3)}


@compiled
def stiffening(h, bend):
    """Further re-opening torque (N m); bend: from rest (rad)."""
    return h.nonlinear_spring_cubic * bend * bend * bend
