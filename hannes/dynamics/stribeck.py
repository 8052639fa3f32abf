"""Stribeck breakaway of motor and gear: harder to start than to keep going."""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def breakaway(motor_speed, torque, speed):
    """Peak of friction at `speed` [rad/s]: sqrt(2e) T u exp(-u^2), u = w / (sqrt(2) speed)."""
    x = motor_speed / speed  # sqrt(2) u
    return torque * x * math.exp(0.5 - 0.5 * x * x)


EFFECT = Effect(
    name="stribeck",
    meaning="Motor and gear hold back at their first turn, and let go once they slide.",
    equation="T_friction += sqrt(2e) torque u exp(-u^2), u = w / (sqrt(2) speed)",
    source="Armstrong & Canudas de Wit (1995), in the form of the paper's eq. 1",
    parameters=(
        Parameter("torque", 0.0, "N m", (0.0, 0.02), "of the peak, motor side", off=0.0),
        Parameter("speed", 20.0, "rad/s", (0.5, 500.0), "of the motor at the peak"),
    ),
    terms=(Term(breakaway, writes=("gear_friction",), unit="N m"),),
)
