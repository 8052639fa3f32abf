"""Lag of the dynamometer: its amplifier filters both force channels of the log.

    time m' = F - m,  F_measured = m

The hand itself feels nothing of it. Source: first-order low pass; a real robot hand's force
reading lags by 0.145 s. Range: 1 to 200 ms.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.laws import held
from benchmarks.truth.size import Size

SIZES = {"time": Size("s", 1e-3, 0.2)}


@compiled
def filtered(h, start, gain, force):
    """Filtered force (N) after an implicit part-step from `start`, and its rate (N/s)."""
    if h.force_lag_time <= 0.0:
        return force, 0.0
    m = held(start, gain, force / h.force_lag_time, 1.0 / h.force_lag_time)
    return m, (force - m) / h.force_lag_time
