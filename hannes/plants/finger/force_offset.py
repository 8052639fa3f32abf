"""Force-sensor offset: the reading is off by the same number always."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def shifted(size):
    """Counts on top of the force."""
    return size


EFFECT = Effect(
    name="force_offset",
    meaning="The force sensor's zero is elsewhere.",
    equation="reading = F + size",
    source="Doebelin (2003), zero drift",
    parameters=(Parameter("size", 0.0, "1", (-200.0, 200.0), "counts at no force", off=0.0),),
    terms=(Term(shifted, writes=("logged_force",)),),
)
