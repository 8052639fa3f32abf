"""Outside the catalogue: a thumb that strikes index and middle finger as they close.

    T_open = 3 N m/rad max(0, a - free),  a = q_thumb + q_finger,  free = a_end - lost

at the MCP joints of both that meet, with 5 mN m s/rad of damping that never pulls; a_end: a at both
closing stops. The thumb's plane lies between those of the two fingers. Source: geometry of a thumb
that was mounted turned; stiffness of a printed phalanx. Range: 1.1 to 1.9 rad lost of the 2.2 rad
between rest and stops; a free closure of the paper uses 1.2 rad.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.laws import one_sided
from benchmarks.truth.size import Size
from benchmarks.truth.state import ANGLE, SPEED

SIZES = {"lost": Size("rad", 1.1, 1.9)}
STIFFNESS, DAMPING, ONSET = 3.0, 5e-3, 1e-3  # N m/rad, N m s/rad, rad
REACHED, THUMB = 2, 4  # fingers below the first are reached


@compiled
def push(h, f, y):
    """Torque (N m) that opens the MCP joint of finger f."""
    if h.striking_thumb_lost == 0.0:
        return 0.0
    if f == THUMB:
        return _struck(h, 0, y) + _struck(h, 1, y)
    return _struck(h, f, y) if f < REACHED else 0.0


@compiled
def _struck(h, f, y):
    thumb, finger = 2 * THUMB, 2 * f
    free = h.fingers_mcp_upper[THUMB] + h.fingers_mcp_upper[f] - h.striking_thumb_lost
    deep = y[ANGLE + thumb] + y[ANGLE + finger] - free
    rate = y[SPEED + thumb] + y[SPEED + finger]
    return one_sided(deep, rate, STIFFNESS, DAMPING, ONSET)
