"""Gain error of the current sensor, for the controller and for the log.

    i_measured = (1 + error) i

Source: tolerance of shunts and Hall sensors (data sheets). Range: 0.5 % to 15 %, both signs.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"error": Size("1", -0.15, 0.15)}


@compiled
def amplified(h, current):
    """Reading of the sensor (A)."""
    return current * (1.0 + h.current_gain_error)
