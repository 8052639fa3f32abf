"""Force-sensor lag: the logged force follows the real one late."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def trailing(force, lagging, time):
    """What the log lacks of a force [N], and the rate of what it has [N/s]."""
    if time <= 0.0:
        return 0.0, 0.0
    behind = lagging - force
    return behind, -behind / time


@kernel
def grip(logged_force, lagging_force, time):
    """Of a finger's normal forces."""
    return trailing(logged_force, lagging_force, time)


@kernel
def face(logged_sensor, lagging_sensor, time):
    """Of a finger's push on the dynamometer's sensing face."""
    return trailing(logged_sensor, lagging_sensor, time)


EFFECT = Effect(
    name="force_lag",
    meaning="The force sensor answers slowly, so its reading trails the grip.",
    equation="time m' = F - m, logged force and sensor = m",
    source="Doebelin (2003), first-order instrument",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.5), "constant of the sensor", off=0.0),),
    terms=(
        Term(grip, writes=("logged_force",), states=("lagging_force",)),
        Term(face, writes=("logged_sensor",), states=("lagging_sensor",)),
    ),
    states=(
        Slot("lagging_force", "N", "a finger's share of the logged force", "finger", 5, 1e-2),
        Slot("lagging_sensor", "N", "a finger's share of the sensing face's", "finger", 5, 1e-2),
    ),
)
