"""Wire compliance beyond the base: longer wires, crimps and sheaths that give."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def softer_leader(leader):
    """Compliance in series with the leader wire [m/N]."""
    return leader


@kernel
def softer_follower(follower):
    """Compliance in series with each follower wire [m/N]."""
    return follower


EFFECT = Effect(
    name="wire_compliance",
    meaning="The wires give more under load than their nominal stiffness.",
    equation="1/k_leader += leader, 1/k_follower += follower",
    source="Palli, Borghesan & Melchiorri (2012), elastic tendons",
    parameters=(
        Parameter("leader", 0.0, "m/N", (0.0, 1e-4), "added to the leader", off=0.0),
        Parameter("follower", 0.0, "m/N", (0.0, 1e-4), "added to each follower", off=0.0),
    ),
    terms=(
        Term(softer_leader, writes=("leader_compliance",)),
        Term(softer_follower, writes=("follower_compliance",)),
    ),
)
