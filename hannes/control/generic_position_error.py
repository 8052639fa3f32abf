"""Generic disturbance: an error of the encoder, over its own value."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed

TRAVEL = 10.0  # rad, of a whole closure


@kernel
def over_position(position, c_0, c_1, c_2, c_3, c_4):
    """Error of the reading [rad] at an angle of the output shaft [rad]."""
    return legendre(placed(position, 0.0, TRAVEL), c_0, c_1, c_2, c_3, c_4)


@kernel
def error(shaft_position, c_0, c_1, c_2, c_3, c_4):
    """Added to the reading [rad]."""
    return over_position(shaft_position, c_0, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_position_error",
        meaning="The encoder's reading is off by its own value. It describes, and names no cause.",
        equation="phi_measured += sum c_k P_k(2 phi / travel - 1)",
        source="Legendre's polynomials",
        parameters=coefficients("rad", 0.3),
        terms=(Term(error, writes=("measured_position",), unit="rad"),),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="the encoder's error",
    value_unit="rad",
    law=over_position,
)
