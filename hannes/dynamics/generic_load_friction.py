"""Generic disturbance: any friction of motor and gear, over the load that they bear."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed
from hannes.core.kernels.vector_math import soft_sign

HEAVIEST = 0.04  # N m, of the wire on the motor


@kernel
def over_load(load, c_0, c_1, c_2, c_3, c_4):
    """Friction [N m] at a load on the motor [N m]."""
    return legendre(placed(load, 0.0, HEAVIEST), c_0, c_1, c_2, c_3, c_4)


@kernel
def friction(motor_speed, motor_friction_speed, load, c_0, c_1, c_2, c_3, c_4):
    """Added to the friction of motor and gear [N m]."""
    level = over_load(load, c_0, c_1, c_2, c_3, c_4)
    return soft_sign(motor_speed / motor_friction_speed) * level


GENERIC = Description(
    Effect(
        name="generic_load_friction",
        meaning="The friction of motor and gear depends on their load. It describes, and names no "
        "cause.",
        equation="T_friction += tanh(w / w_s) sum c_k P_k(2 tl / tl_max - 1)",
        source="Legendre's polynomials",
        parameters=coefficients("N m", 0.01),
        terms=(Term(friction, writes=("gear_friction",), unit="N m"),),
    ),
    axis="the load on the motor",
    unit="N m",
    ends=(0.0, HEAVIEST),
    value="further friction of motor and gear",
    value_unit="N m",
    law=over_load,
)
