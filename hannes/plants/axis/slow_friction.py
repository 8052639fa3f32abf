"""Friction of an axis near standstill, in newton: more than Coulomb's there (Stribeck), or less."""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter


@kernel
def near_rest(motor_speed, motor_friction_speed, force, speed):
    """Friction that vanishes as the axis speeds up [N]."""
    share = motor_speed / speed
    return force * soft_sign(motor_speed / motor_friction_speed) * math.exp(-share * share)


EFFECT = Effect(
    name="slow_friction",
    meaning="The friction of the axis near standstill differs from that in motion.",
    equation="F_friction += force tanh(v / v_s) exp(-(v / speed)^2)",
    source="Armstrong-Helouvry (1991), Stribeck friction; of either sign",
    parameters=(
        Parameter("force", 0.0, "N", (-20.0, 20.0), "near standstill", off=0.0),
        Parameter("speed", 0.02, "m/s", (2e-3, 0.2), "at which it is gone"),
    ),
    terms=(Term(near_rest, writes=("gear_friction",), unit="N"),),
)
