"""Generic disturbance: any friction of motor and gear, over the motor's angle."""

from hannes.core.description import Description, waves
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.dynamics.generic_motor_torque import TRAVEL, over_angle


@kernel
def friction(
    motor_angle, motor_speed, motor_friction_speed, gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6
):
    """Added to the friction of motor and gear [N m]."""
    level = over_angle(motor_angle / gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6)
    return soft_sign(motor_speed / motor_friction_speed) * level


GENERIC = Description(
    Effect(
        name="generic_angle_friction",
        meaning="The friction of motor and gear depends on the motor's angle. It describes, and "
        "names no cause.",
        equation="T_friction += tanh(w / w_s) sum c_k cos(k pi th / (N travel))",
        source="Fourier's series",
        parameters=waves("N m", 0.01),
        terms=(Term(friction, writes=("gear_friction",), unit="N m"),),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="further friction of motor and gear",
    value_unit="N m",
    law=over_angle,
)
