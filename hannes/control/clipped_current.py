"""A clipped current sensor: beyond its range it reports the end of its range."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def cut_off(delayed_current, inverse_range):
    """What the reading lacks of the current: clip(i, -range, range) - i [A]."""
    if inverse_range <= 0.0:
        return 0.0
    largest = 1.0 / inverse_range
    return min(max(delayed_current, -largest), largest) - delayed_current


EFFECT = Effect(
    name="clipped_current",
    meaning="The current sensor cannot read beyond its range, and reports the end of it.",
    equation="i_measured = clip(i, -range, range), range = 1 / inverse_range",
    source="Ziegler, Woodward, Iu & Borle (2009), range of current sensors",
    parameters=(
        Parameter("inverse_range", 0.0, "1/A", (0.0, 5.0), "1 / largest current read", off=0.0),
    ),
    terms=(Term(cut_off, writes=("measured_current",)),),
)
