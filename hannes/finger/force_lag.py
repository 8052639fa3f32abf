"""Force-sensor lag: the reading follows the real force late, as a filter or a creeping pad does."""

from hannes._jit import kernel
from hannes.effect import Effect, Term
from hannes.layout import Slot
from hannes.parameter import Parameter


@kernel
def trailing(told_force, first_reading, lagging_force, time):
    """What the reading lacks of the force, and the rate of what it has; it starts as recorded."""
    if time <= 0.0:
        return 0.0, 0.0
    behind = first_reading + lagging_force - told_force
    return behind, -behind / time


EFFECT = Effect(
    name="force_lag",
    meaning="The force sensor answers slowly, so its reading trails the grip.",
    equation="time m' = F - m, reading = m",
    source="Doebelin (2003), first-order instrument",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.5), "constant of the sensor", off=0.0),),
    terms=(Term(trailing, writes=("told_force",), states=("lagging_force",)),),
    states=(Slot("lagging_force", "1", "reading less the first one", tolerance=1.0),),
)
