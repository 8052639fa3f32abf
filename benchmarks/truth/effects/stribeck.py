"""Stribeck breakaway of motor and gear: friction that peaks just above standstill.

    T_friction += sqrt(2 e) torque exp(-u^2) u,  u = w / (sqrt(2) speed)

w: motor speed; the peak is `torque`, at w = `speed`. The base has such a peak at the joints and
the carts (equations 1 and 2) but none at the motor.
Source: equation 1 of the paper, after Armstrong & Canudas de Wit (1995). Range: 5 % to 100 % of the
nominal dry friction of 4.7 mN m, at 5 to 60 rad/s.
"""

from math import exp, sqrt

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "torque": Size("N m", 0.2e-3, 5e-3),
    "speed": Size("rad/s", 5.0, 60.0, default=20.0, amplitude=False),
}


@compiled
def peak(h, speed):
    """Torque (N m) that opposes the motor's speed (rad/s)."""
    u = speed / (sqrt(2.0) * h.stribeck_speed)
    return sqrt(2.0 * exp(1.0)) * h.stribeck_torque * exp(-u * u) * u
