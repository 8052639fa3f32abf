"""Current-sensor gain: the sensor reports too much or too little of every current."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def exaggerated(delayed_current, error):
    """Added to the reading [A], a share of what is sensed."""
    return error * delayed_current


EFFECT = Effect(
    name="current_gain",
    meaning="The current sensor reports a few percent too much or too little.",
    equation="i_measured += error i",
    source="Ziegler, Woodward, Iu & Borle (2009), errors of current sensors",
    parameters=(Parameter("error", 0.0, "1", (-0.4, 0.4), "of the gain", off=0.0),),
    terms=(Term(exaggerated, writes=("measured_current",)),),
)
