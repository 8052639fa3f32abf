"""Command delay: what is asked of the hand reaches its controller late."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def late(time):
    """Shift of the time at which the reference is read [s]; exact."""
    return -time


EFFECT = Effect(
    name="command_delay",
    meaning="Commands reach the controller late, and so the whole motion is late.",
    equation="the reference used at t is that of t - time",
    source="Nilsson (1998), real-time control systems with delays",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.05), "of the delay", off=0.0),),
    terms=(Term(late, writes=("reference_time",)),),
)
