"""Viscoelastic object: under a held grip it creeps, and the force relaxes."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def creeping(penetration, object_stiffness, crept, share, time):
    """Force lost to the dent d = share * crept under a phalanx [N], and crept's rate [m/s]."""
    dent = share * crept
    return -object_stiffness * dent, (max(0.0, penetration - dent) - crept) / time


EFFECT = Effect(
    name="viscoelastic_object",
    meaning="The object creeps while it is held, so the grip fades though nothing moves.",
    equation="F = k (x - d) + beta x' ramp(x), d' = (share max(0, x - d) - d) / time",
    source="Zener (1948), standard linear solid",
    parameters=(
        Parameter("share", 0.0, "1", (0.0, 5.0), "of creep in what springs back", off=0.0),
        Parameter("time", 0.15, "s", (1e-3, 100.0), "of the creep"),
    ),
    terms=(Term(creeping, writes=("normal_force",), states=("crept",)),),
    states=(Slot("crept", "m", "dent that stays for a while, per share", "phalanx", 10, 1e-7),),
)
