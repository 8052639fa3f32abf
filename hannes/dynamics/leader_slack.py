"""Leader-wire slack: wire that must be wound before anything moves."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def free_length(length):
    """Slack added to the leader wire [m]."""
    return length


EFFECT = Effect(
    name="leader_slack",
    meaning="The leader wire has come loose, so the motor's first turns only wind it up.",
    equation="s_L = r_p th/N - length - (2 x_A + 2 x_B + l_thumb)",
    source="the paper's discussion of Fig. 7, which could not model it",
    parameters=(Parameter("length", 0.0, "m", (0.0, 0.02), "of loose wire", "choice", off=0.0),),
    terms=(Term(free_length, writes=("slack",)),),
)
