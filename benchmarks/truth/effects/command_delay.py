"""Command delay: the hand follows its reference later than the log's clock says.

    reference(t) used = reference(t - time)

The log keeps the reference as it was asked. A start jitter between runs is the same with zero mean.
Source: transport delay of a serial bus. Range: 0.1 to 10 ms.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"time": Size("s", 1e-4, 1e-2)}


@compiled
def heard(h, t):
    """Time (s) of the reference that is acted upon at t."""
    return t - h.command_delay_time
