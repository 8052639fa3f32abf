"""Measurement delay: controller and log see position and current that are older than they think.

    position(t), current(t) measured = position(t - time), current(t - time)

Duty and supply are not delayed, nor the forces (another instrument). Only for the sampled
controller, where the past is kept exactly. Source: transport delay of converters and bus (Astrom &
Wittenmark 1997). Range: 0.1 to 5 ms.
"""

from math import floor

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"time": Size("s", 1e-4, 5e-3)}


@compiled
def looked_up(h, period):
    """Periods to go back, and the time (s) of the reading from that tick's start."""
    periods = h.measurement_delay_time / period
    back = floor(periods + 1.0 - 1e-9)
    return int(back), (back - periods) * period
