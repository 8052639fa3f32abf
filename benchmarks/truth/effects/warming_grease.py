"""Grease of motor and gear that thins as friction warms it.

    T_friction = T_cold / (1 + fall E),  E' = T_cold w,  E = 0 at the start of a run

E: the work that friction would have done without warming. So falls friction that is
exponential in the heat Q which it makes: Q' = T_cold w exp(-fall Q), exp(fall Q) = 1 + fall E.
No heat is lost in the seconds of a run.
Source: Reynolds (1886), viscosity of oils over temperature. Range: a fall by 3 % for each joule
(a thin oil) to one by two thirds (a stiff grease in the cold).
"""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size
from benchmarks.truth.state import MOTOR_SPEED, WORK

SIZES = {"fall": Size("1/J", 0.03, 1.0)}


@compiled
def cold(h, speed):
    """Friction (N m) of motor and gear before they warm."""
    dry = h.motor_dry_friction * tanh(speed / h.motor_friction_speed)
    return dry + h.motor_viscous_friction * speed


@compiled
def spend(h, start, gain, y, dy):
    """Writes the work of cold friction (J) and its rate."""
    dy[WORK] = cold(h, y[MOTOR_SPEED]) * y[MOTOR_SPEED]
    y[WORK] = start[WORK] + gain * dy[WORK]


@compiled
def missing(h, speed, work):
    """Friction (N m) that a warm machine lacks."""
    warmth = h.warming_grease_fall * work
    return cold(h, speed) * warmth / (1.0 + warmth)
