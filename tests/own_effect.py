"""The file of a user's own effect, to be filled with the code of its kernel `rub`."""

EFFECT = """\
from hannes.core.kernels.jit import kernel
from hannes.core.effect import Effect, Term
from hannes.core.parameter import Parameter

{code}

EFFECT = Effect(
    name="mine",
    meaning="A test.",
    equation="none",
    source="none",
    parameters=(Parameter("size", 0.1, "1", (0.0, 1.0), "of it", off=0.0),),
    terms=(Term(rub, writes=("gear_friction",)),),
)
"""
