"""Lag of the current sensor: a first-order filter before the controller and the log.

    time m' = i - m,  i_measured = m

Source: anti-aliasing filter of a shunt amplifier. Range: 0.1 to 10 ms.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.laws import held
from benchmarks.truth.size import Size

SIZES = {"time": Size("s", 1e-4, 1e-2)}


@compiled
def filtered(h, start, gain, current):
    """Filtered current (A) after an implicit part-step from `start`, and its rate (A/s)."""
    if h.current_lag_time <= 0.0:
        return current, 0.0
    m = held(start, gain, current / h.current_lag_time, 1.0 / h.current_lag_time)
    return m, (current - m) / h.current_lag_time
