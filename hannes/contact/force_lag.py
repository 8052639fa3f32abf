"""Force-sensor lag: the logged force follows the real one late."""

from hannes._jit import kernel
from hannes.effect import Effect, Term
from hannes.layout import Slot
from hannes.parameter import Parameter


@kernel
def following(told_force, told_sensor, lagging_force, lagging_sensor, time):
    """What the log lacks of one finger's forces [N], and the rates of what it has [N/s]."""
    if time <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    behind, short = lagging_force - told_force, lagging_sensor - told_sensor
    return behind, short, -behind / time, -short / time


EFFECT = Effect(
    name="force_lag",
    meaning="The force sensor answers slowly, so its reading trails the grip.",
    equation="time m' = F - m, logged force and sensor = m",
    source="Doebelin (2003), first-order instrument",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.5), "constant of the sensor", off=0.0),),
    terms=(
        Term(
            following,
            writes=("told_force", "told_sensor"),
            states=("lagging_force", "lagging_sensor"),
        ),
    ),
    states=(
        Slot("lagging_force", "N", "a finger's share of the logged force", "finger", 5, 1e-2),
        Slot("lagging_sensor", "N", "a finger's share of the sensing face's", "finger", 5, 1e-2),
    ),
)
