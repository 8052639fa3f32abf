"""Generic disturbance: an error of the encoder, over its own value; none where it was zeroed."""

from hannes.core.description import Description, waves_from_zero
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import cosines_from_zero

TRAVEL = 10.0  # rad, of a whole closure: the series is mirrored beyond


@kernel
def over_position(position, c_1, c_2, c_3, c_4, c_5, c_6):
    """Error of the reading [rad] at an angle of the output shaft [rad]."""
    return cosines_from_zero(position / TRAVEL, c_1, c_2, c_3, c_4, c_5, c_6)


@kernel
def error(shaft_position, c_1, c_2, c_3, c_4, c_5, c_6):
    """Added to the reading [rad]."""
    return over_position(shaft_position, c_1, c_2, c_3, c_4, c_5, c_6)


GENERIC = Description(
    Effect(
        name="generic_position_error",
        meaning="The encoder's reading is off by its own value. It describes, and names no cause.",
        equation="phi_measured += sum c_k (cos(k pi phi / travel) - 1)",
        source="Fourier's series",
        parameters=waves_from_zero("rad", 0.3),
        terms=(Term(error, writes=("measured_position",), unit="rad"),),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="the encoder's error",
    value_unit="rad",
    law=over_position,
)
