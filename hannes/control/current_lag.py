"""Current-sensor lag: the reading follows the winding's current late."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def trailing(motor_current, smoothed, time):
    """The reading less the current [A], and the rate of the reading [A/s]."""
    if time <= 0.0:
        return 0.0, 0.0
    behind = smoothed - motor_current
    return behind, -behind / time


EFFECT = Effect(
    name="current_lag",
    meaning="The current sensor is filtered, so its reading trails the current.",
    equation="time m' = i - m, i_measured = m",
    source="Ziegler, Woodward, Iu & Borle (2009), bandwidth of current sensors",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.02), "constant of the filter", off=0.0),),
    terms=(Term(trailing, writes=("sensed_current",), states=("smoothed",)),),
    states=(Slot("smoothed", "A", "m, behind the filter", tolerance=1e-4),),
)
