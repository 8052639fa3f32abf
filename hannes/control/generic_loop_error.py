"""Generic disturbance: the position loop acts on other errors than it sees, over the error."""

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

FINEST, RATIO = 3e-3, 4.0  # rad, of the output shaft: where the finest share is whole
REACH = FINEST * RATIO**3  # rad, likewise the widest


@kernel
def over_error(error, c_1, c_2, c_3, c_4):
    """Error acted on beyond the true one [rad], over that [rad]: four ramps, each to its end."""
    finest = FINEST
    return (
        c_1 * min(max(error / finest, -1.0), 1.0)
        + c_2 * min(max(error / (finest * RATIO), -1.0), 1.0)
        + c_3 * min(max(error / (finest * RATIO * RATIO), -1.0), 1.0)
        + c_4 * min(max(error / (finest * RATIO * RATIO * RATIO), -1.0), 1.0)
    )


@kernel
def acted_on(position_error, gear_ratio, c_1, c_2, c_3, c_4):
    """Added to the error that the position loop acts on [rad], motor side."""
    return gear_ratio * over_error(position_error / gear_ratio, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_loop_error",
        meaning="The position loop acts on another error than it sees. It names no cause.",
        equation="e += sum c_k ramp(e / e_k), ramp(x) = x within 1, else sign(x)",
        source="piecewise linear, each ramp four times wider",
        parameters=tuple(
            Parameter(f"c_{k}", 0.0, "rad", (-0.15, 0.15), f"of ramp {k}", "choice", off=0.0)
            for k in range(1, 5)
        ),
        terms=(Term(acted_on, writes=("position_error",), unit="rad"),),
    ),
    axis="the error at the output shaft",
    unit="rad",
    ends=(-REACH, REACH),
    value="an error that is acted on beyond it",
    value_unit="rad",
    law=over_error,
)
