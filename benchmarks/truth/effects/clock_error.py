"""Outside the catalogue: a board whose clock is slow, so that each of its periods lasts longer.

    dt = (1 + share) dt_board

Commands, control and log go by the board's clock; motor and fingers do not. A negative share is a
fast clock. Only for the sampled controller. Source: tolerance of oscillators (data sheets). Range:
1 % to 15 % (RC oscillators, trimmed and as they come), both signs.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"share": Size("1", -0.15, 0.15)}


@compiled
def lasting(h):
    """How long a second of the board's clock lasts (s)."""
    return 1.0 + h.clock_error_share
