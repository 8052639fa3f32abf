"""Generic disturbance: any friction of both carts, over their travel."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed
from hannes.core.kernels.vector_math import soft_sign

TRAVEL = 10e-3  # m, of a whole closure


@kernel
def over_travel(travel, c_0, c_1, c_2, c_3, c_4):
    """Friction [N] at a cart's travel [m]."""
    return legendre(placed(travel, 0.0, TRAVEL), c_0, c_1, c_2, c_3, c_4)


@kernel
def friction(cart_position, cart_speed, cart_breakaway_speed, c_0, c_1, c_2, c_3, c_4):
    """Against a cart's motion [N]."""
    level = over_travel(cart_position, c_0, c_1, c_2, c_3, c_4)
    return soft_sign(cart_speed / cart_breakaway_speed) * level


GENERIC = Description(
    Effect(
        name="generic_cart_friction",
        meaning="The friction of both carts depends on their travel. It describes, and names no "
        "cause.",
        equation="F_cart += tanh(v / v_b) sum c_k P_k(2 x / travel - 1)",
        source="Legendre's polynomials",
        parameters=coefficients("N", 20.0),
        terms=(Term(friction, writes=("cart_friction",), unit="N"),),
    ),
    axis="a cart's travel",
    unit="m",
    ends=(0.0, TRAVEL),
    value="further friction of the cart",
    value_unit="N",
    law=over_travel,
)
