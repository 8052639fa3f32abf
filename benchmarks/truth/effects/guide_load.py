"""Load-dependent friction of the carts' linear guides.

    F = coefficient |T_before + T_behind| tanh(v / v_b)

T_before, T_behind: the leader on either side of the cart's pulley, as capstan friction leaves it;
v: speed of the cart; v_b: `cart.breakaway_speed`. The pull does not lie on the guide's line, and
the guide bears its moment.
Source: Coulomb (1785); ISO 14728-1 (2017). Range: a ball guide (0.003) to a dry plain one (0.15).
"""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"coefficient": Size("1", 3e-3, 0.15)}


@compiled
def drag(h, pull, speed):
    """Friction (N) against a cart with a speed (m/s) that the leader pulls at (N)."""
    return h.guide_load_coefficient * abs(pull) * tanh(speed / h.cart_breakaway_speed)
