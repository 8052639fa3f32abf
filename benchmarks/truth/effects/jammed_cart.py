"""Outside the catalogue: carts that jam the further they run along a warped or dirty guide.

    F = gradient max(0, x - from) tanh(v / v_b)

against both carts; x: travel of each, 8 mm in a free closure; v_b: `cart.breakaway_speed`. Source:
Coulomb (1785), with a normal force that grows as the carriage is wedged. Range: 0.2 to 8 N/mm,
which is 1 to 40 N at the end of the travel.
"""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {
    "gradient": Size("N/m", 200.0, 8000.0),
    "from": Size("m", 1e-3, 4e-3, default=3e-3, amplitude=False),
}


@compiled
def drag(h, place, speed):
    """Friction (N) against a cart at a place (m) with a speed (m/s)."""
    wedged = place - h.jammed_cart_from
    if h.jammed_cart_gradient == 0.0 or wedged <= 0.0:
        return 0.0
    return h.jammed_cart_gradient * wedged * tanh(speed / h.cart_breakaway_speed)
