"""Generic disturbance: an error of the current sensor, over its own value."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed

MOST = 2.5  # A


@kernel
def over_current(current, c_0, c_1, c_2, c_3, c_4):
    """Error of the reading [A] at a current [A]."""
    return legendre(placed(current, -MOST, MOST), c_0, c_1, c_2, c_3, c_4)


@kernel
def error(sensed_current, c_0, c_1, c_2, c_3, c_4):
    """Added to the reading [A]."""
    return over_current(sensed_current, c_0, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_current_error",
        meaning="The current sensor's reading is off by its own value. It describes, and names no "
        "cause.",
        equation="i_measured += sum c_k P_k(i / i_max)",
        source="Legendre's polynomials",
        parameters=coefficients("A", 0.5),
        terms=(Term(error, writes=("measured_current",), unit="A"),),
    ),
    axis="the current",
    unit="A",
    ends=(-MOST, MOST),
    value="the current sensor's error",
    value_unit="A",
    law=over_current,
)
