"""Outside the catalogue: an encoder whose magnet is off the shaft's centre.

    position = phi + error (sin(phi + phase) - sin(phase))

phi: output-shaft angle; the encoder is set to zero at rest. The controller and the log read it
alike. Source: off-axis error of magnetic encoders, once a turn (data sheets). Range: 0.3 degrees
to 7 degrees (a magnet that has come loose).
"""

from math import sin

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "error": Size("rad", 5e-3, 0.12),
    "phase": Size("rad", -3.14, 3.14, amplitude=False),
}


@compiled
def seen(h, angle):
    """Angle (rad) that the magnet shows at an angle (rad) of the output shaft."""
    error, phase = h.encoder_eccentricity_error, h.encoder_eccentricity_phase
    if error == 0.0:
        return angle
    return angle + error * (sin(angle + phase) - sin(phase))
