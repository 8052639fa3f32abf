"""Force-sensor lag of one finger: as the hand's, but the reading starts as it was recorded."""

from hannes.contact.force_lag import EFFECT as HAND_LAG
from hannes.contact.force_lag import trailing
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot


@kernel
def reading(logged_force, first_reading, lagging_force, time):
    """The reading less the force, and the rate of the reading beyond the first one."""
    return trailing(logged_force, first_reading + lagging_force, time)


EFFECT = Effect(
    name=HAND_LAG.name,
    meaning=HAND_LAG.meaning,
    equation="time m' = F - m, reading = m",
    source=HAND_LAG.source,
    parameters=HAND_LAG.parameters,
    terms=(Term(reading, writes=("logged_force",), states=("lagging_force",)),),
    states=(Slot("lagging_force", "1", "reading less the first one", tolerance=1.0),),
)
