"""Generic disturbance: any friction of motor and gear, over speed and by direction."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed
from hannes.core.kernels.vector_math import soft_sign

FASTEST = 30.0  # rad/s, of the output shaft


@kernel
def over_speed(speed, c_0, c_1, c_2, c_3, c_4):
    """Friction [N m] against the motion at a speed of the output shaft [rad/s]."""
    return legendre(placed(speed, -FASTEST, FASTEST), c_0, c_1, c_2, c_3, c_4)


@kernel
def friction(motor_speed, motor_friction_speed, gear_ratio, c_0, c_1, c_2, c_3, c_4):
    """Added to the friction of motor and gear [N m]."""
    level = over_speed(motor_speed / gear_ratio, c_0, c_1, c_2, c_3, c_4)
    return soft_sign(motor_speed / motor_friction_speed) * level


GENERIC = Description(
    Effect(
        name="generic_speed_friction",
        meaning="The friction of motor and gear depends on speed. It describes, and names no "
        "cause.",
        equation="T_friction += tanh(w / w_s) sum c_k P_k(w / (N w_max))",
        source="Legendre's polynomials",
        parameters=coefficients("N m", 0.005),
        terms=(Term(friction, writes=("gear_friction",), unit="N m"),),
    ),
    axis="the output shaft's speed",
    unit="rad/s",
    ends=(-FASTEST, FASTEST),
    value="further friction of motor and gear",
    value_unit="N m",
    law=over_speed,
)
