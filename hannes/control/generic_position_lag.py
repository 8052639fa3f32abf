"""Generic disturbance: the encoder's reading trails, by a time that depends on speed."""

from hannes.control.generic_command_lag import FASTEST, over_speed
from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel


@kernel
def trailing(motor_speed, gear_ratio, c_0, c_1, c_2):
    """Added to the reading [rad]: what the shaft turns within the lag."""
    speed = motor_speed / gear_ratio
    return -speed * over_speed(speed, c_0, c_1, c_2)


GENERIC = Description(
    Effect(
        name="generic_position_lag",
        meaning="The encoder's reading trails, by speed. It describes, and names no cause.",
        equation="phi_measured -= w / N sum c_k P_k(w / (N w_max))",
        source="Legendre's polynomials",
        parameters=coefficients("s", 0.03, 3),
        terms=(Term(trailing, writes=("measured_position",), unit="rad"),),
    ),
    axis="the output shaft's speed",
    unit="rad/s",
    ends=(-FASTEST, FASTEST),
    value="the lag of the position's reading",
    value_unit="s",
    law=over_speed,
)
