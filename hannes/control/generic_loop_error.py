"""Generic disturbance: the position loop acts on another error than it sees, over that error.

What it acts on has never the other sign. Small errors have finer places than large ones.
"""

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

PLACES = 3e-3, 12e-3, 48e-3, 150e-3  # rad, of the output shaft: of the four values
FIRST, SECOND, THIRD, FOURTH = PLACES


@kernel
def over_error(error, c_1, c_2, c_3, c_4):
    """Error acted on beyond that seen [rad], over that [rad]: odd, linear from place to place."""
    size = abs(error)
    if size < FIRST:
        value = c_1 * size / FIRST
    elif size < SECOND:
        value = c_1 + (c_2 - c_1) * (size - FIRST) / (SECOND - FIRST)
    elif size < THIRD:
        value = c_2 + (c_3 - c_2) * (size - SECOND) / (THIRD - SECOND)
    elif size < FOURTH:
        value = c_3 + (c_4 - c_3) * (size - THIRD) / (FOURTH - THIRD)
    else:
        value = c_4
    return value if error > 0.0 else -value


@kernel
def acted_on(position_error, gear_ratio, c_1, c_2, c_3, c_4):
    """Added to the error that the position loop acts on [rad], motor side."""
    return gear_ratio * over_error(position_error / gear_ratio, c_1, c_2, c_3, c_4)


def _value(number: int, place: float) -> Parameter:
    return Parameter(
        f"c_{number}", 0.0, "rad", (-place, place), f"at {place:g} rad", "choice", off=0.0
    )


GENERIC = Description(
    Effect(
        name="generic_loop_error",
        meaning="The position loop acts on another error than it sees. It names no cause.",
        equation="e += sign(e) v(|e|), v linear between its values c_k at e_k, constant beyond",
        source="linear interpolation",
        parameters=tuple(_value(k, place) for k, place in enumerate(PLACES, 1)),
        terms=(Term(acted_on, writes=("position_error",), unit="rad"),),
    ),
    axis="the error at the output shaft",
    unit="rad",
    ends=(-FOURTH, FOURTH),
    value="an error that is acted on beyond it",
    value_unit="rad",
    law=over_error,
)
