"""A current sensor that reads no more than the end of its range.

    i_measured = clip(i, -1 / inverse_range, 1 / inverse_range)

for the controller and for the log.
Source: full scale of shunt amplifiers and their converters (data sheets). Range: full scale from
3.3 A, above what the hand draws for long, to 0.4 A, less than closing takes.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"inverse_range": Size("1/A", 0.3, 2.5)}


@compiled
def current_error(h, current):
    """What the reading lacks (A), negative above the range."""
    over = abs(current) * h.clipped_current_inverse_range - 1.0
    if over <= 0.0:
        return 0.0
    return -over / h.clipped_current_inverse_range * (1.0 if current > 0.0 else -1.0)
