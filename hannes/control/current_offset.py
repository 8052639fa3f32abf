"""Current-sensor offset: the sensor reports a current where there is none."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def shifted(offset):
    """Added to the reading [A]."""
    return offset


EFFECT = Effect(
    name="current_offset",
    meaning="The current sensor's zero is off, for the controller and in the log.",
    equation="i_measured += offset",
    source="Ziegler, Woodward, Iu & Borle (2009), errors of current sensors",
    parameters=(Parameter("offset", 0.0, "A", (-0.5, 0.5), "of the reading", off=0.0),),
    terms=(Term(shifted, writes=("measured_current",)),),
)
