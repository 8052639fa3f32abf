"""Direction-dependent friction: harder one way than the other."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter


@kernel
def asymmetry(
    motor_speed, motor_dry_friction, motor_friction_speed, motor_viscous_friction, dry, viscous
):
    """Friction (1 + a) closing and (1 - a) opening, dry and viscous apart: what this adds."""
    slide = abs(soft_sign(motor_speed / motor_friction_speed))
    return dry * motor_dry_friction * slide + viscous * motor_viscous_friction * abs(motor_speed)


EFFECT = Effect(
    name="direction_friction",
    meaning="Motor and gear rub harder in one direction than in the other.",
    equation="T_friction += dry T_dry |tanh(w / w_s)| + viscous f |w|",
    source="Janot, Gautier & Brunot (2019), asymmetric friction of a screw drive",
    parameters=(
        Parameter("dry", 0.0, "1", (-0.9, 0.9), "asymmetric share of dry friction", off=0.0),
        Parameter("viscous", 0.0, "1", (-0.9, 0.9), "asymmetric share of viscous", off=0.0),
    ),
    terms=(Term(asymmetry, writes=("gear_friction",)),),
)
