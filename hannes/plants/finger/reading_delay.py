"""Pure delay: the reading is that of some time before, otherwise unchanged."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def late(time):
    """Shift of the time at which the angle is read [s]; exact."""
    return -time


EFFECT = Effect(
    name="reading_delay",
    meaning="The force is reported late by a fixed time, as over a polled bus.",
    equation="reading(t) = F(t - time)",
    source="Nilsson (1998), real-time control systems with delays",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.5), "of the delay", off=0.0),),
    terms=(Term(late, writes=("reading_time",)),),
)
