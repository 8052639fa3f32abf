"""Return-spring error: re-opening springs stronger or weaker than they are believed to be.

    T_open = (preload + k (q - q_rest)) (1 + share)   at all ten joints

The stops keep what they carry; with a positive share the open hand presses harder on them.
Source: tolerance of wound springs (DIN 2089, +-5..15 %), and fatigue. Range: 2 % to 40 %, both
signs.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"share": Size("1", -0.4, 0.4)}


@compiled
def real(h, torque):
    """Torque (N m) of a spring that should give `torque`."""
    return torque * (1.0 + h.spring_error_share)
