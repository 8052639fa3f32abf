"""Hysteresis of the return springs: they give back less than they took.

    T_open += share T_spring z,  z' = (q' - |q'| z) / width,  z = 0 at the start

T_spring = preload + k (q - q_rest); z, one for each joint, runs from -1 (opening) to 1 (closing)
within some `width` of travel, at any speed.
Source: Dahl (1968). Range: steel (2 %) to elastomer (40 %), width 0.01 to 0.2 rad.
"""

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "share": Size("1", 0.02, 0.4),
    "width": Size("rad", 0.01, 0.2, default=0.05, amplitude=False),
}


@compiled
def dahl(h, speed):
    """a and b of z' = a - b z at a joint's speed (rad/s)."""
    width = h.spring_hysteresis_width
    return speed / width, abs(speed) / width


@compiled
def lost(h, torque, z):
    """What hysteresis adds to a spring's torque (N m)."""
    return h.spring_hysteresis_share * torque * z
