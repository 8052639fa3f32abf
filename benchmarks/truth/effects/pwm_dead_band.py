"""PWM dead band: a bridge that lets nothing through below a small duty, and that much less above.

    duty_out = 0 where |duty| < width;  duty - width sign(duty) else

The controllers and the log keep the duty that was asked. Source: blanking time of half bridges,
Mohan, Undeland & Robbins (2003). Range: 0.2 % to 8 % duty.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"width": Size("1", 0.002, 0.08)}


@compiled
def passed(h, duty):
    """Share of the bus voltage that reaches the motor."""
    width = h.pwm_dead_band_width
    return duty - min(max(duty, -width), width)
