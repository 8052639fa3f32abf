"""Load-dependent guide friction: a cart's guide rubs harder the more the leader pulls at it."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter


@kernel
def pressed(cart_speed, cart_breakaway_speed, leader_pull, coefficient):
    """Friction by what both sides of the leader pull at a cart: mu |2 T| tanh(v / v_b) [N]."""
    return coefficient * abs(2.0 * leader_pull) * soft_sign(cart_speed / cart_breakaway_speed)


EFFECT = Effect(
    name="guide_load",
    meaning="The carts' guides rub harder the more the leader wire pulls at them.",
    equation="F_cart += coefficient |2 T_L| tanh(v / v_b)",
    source="Coulomb (1785); ISO 14728-1 (2017), linear guides under load",
    parameters=(
        Parameter("coefficient", 0.0, "1", (0.0, 0.5), "friction of the loaded guide", off=0.0),
    ),
    terms=(Term(pressed, writes=("cart_friction",)),),
)
