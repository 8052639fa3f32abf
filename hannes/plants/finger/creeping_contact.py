"""Viscoelastic contact: the force relaxes while the contact rests."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def relaxing(elastic, rested, settled_force, share, time):
    """Force beyond that of rest, and the rate at which rest is reached; it starts rested."""
    beyond = elastic - rested - settled_force
    return share * beyond, beyond / time


EFFECT = Effect(
    name="creeping_contact",
    meaning="Pad and object creep, so that the force sags while the finger rests on them.",
    equation="F = F_e + share (F_e - z), time z' = F_e - z",
    source="Fung (1993), quasi-linear viscoelasticity with one relaxation time",
    parameters=(
        Parameter("share", 0.0, "1", (0.0, 2.0), "of the force that relaxes", off=0.0),
        Parameter("time", 0.3, "s", (0.02, 2.0), "of relaxation"),
    ),
    terms=(Term(relaxing, writes=("contact_force",), states=("settled_force",)),),
    states=(Slot("settled_force", "1", "relaxed force less the first one", tolerance=1.0),),
)
