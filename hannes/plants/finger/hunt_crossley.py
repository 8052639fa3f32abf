"""Hunt-Crossley contact: pressed harder while it closes, and released more softly."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def damped(elastic, closing_speed, damping):
    """Force by speed: F_e times damping times the speed of closing."""
    return elastic * damping * closing_speed


EFFECT = Effect(
    name="hunt_crossley",
    meaning="The contact pushes harder while it is being pressed than while it is released.",
    equation="F = F_e (1 + damping d'), d' in 100 counts/s",
    source="Hunt & Crossley (1975)",
    parameters=(Parameter("damping", 0.0, "s", (0.0, 2.0), "per 100 counts/s", off=0.0),),
    terms=(Term(damped, writes=("contact_force",)),),
)
