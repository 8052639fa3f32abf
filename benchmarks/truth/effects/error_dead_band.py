"""Outside the catalogue: firmware that takes small errors of position for none.

    e used = 0 where |e| < width;  e - width sign(e) else,  e = reference - position

width: at the output shaft. The derivative acts on the speed and stays whole. Source: dead band of
hobby servos against hunting (data sheets). Range: 0.2 to 6 degrees.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"width": Size("rad", 3e-3, 0.1)}


@compiled
def used(h, error):
    """Error (rad) that is acted upon, both at the motor's side."""
    width = h.error_dead_band_width * h.gear_ratio
    if width == 0.0:
        return error
    return error - min(max(error, -width), width)
