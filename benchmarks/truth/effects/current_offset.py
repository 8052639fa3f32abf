"""Offset of the current sensor, for the controller and for the log.

    i_measured = i + offset

Source: input offset of shunt amplifiers and Hall sensors (data sheets). Range: 3 to 200 mA, both
signs.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"offset": Size("A", -0.2, 0.2)}


@compiled
def shifted(h, current):
    """Reading of the sensor (A)."""
    return current + h.current_offset_offset
