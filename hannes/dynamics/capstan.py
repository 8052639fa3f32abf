"""Capstan friction: a wire that slides over a pulley loses tension along the way.

The leader makes half a turn on the pulley of cart A, on the fixed return and on the pulley of
cart B; its speed over each is that of the wire on the thumb's side. Each follower makes half a
turn on its cart's pulley; the mean of its two ends' tensions is that of the stretched wire.
"""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import exp_minus_one, soft_sign
from hannes.core.parameter import Parameter

WIDTH = 5e-3  # m/s, of the change from one direction of sliding to the other


@kernel
def passed(friction, speed):
    """T_out / T_in over half a turn, `speed` [m/s] of the wire from the side of T_in."""
    return 1.0 + exp_minus_one(-friction * math.pi * soft_sign(speed / WIDTH))


@kernel
def along_leader(leader_tension, rate_a, rate_b, rate_thumb, friction):
    """What cart A, cart B and the thumb lack of the tension at the motor pulley [N]."""
    beyond_b = rate_b + rate_thumb
    first = leader_tension * passed(friction, rate_a + rate_b + beyond_b)
    second = first * passed(friction, rate_b + beyond_b)
    third = second * passed(friction, beyond_b)
    mean_a, mean_b = 0.5 * (leader_tension + first), 0.5 * (second + third)
    return mean_a - leader_tension, mean_b - leader_tension, third - leader_tension


@kernel
def over_cart(follower_slip, friction):
    """Share of the mean tension that separates either end from it: their ratio is `passed`."""
    return soft_sign(0.5 * friction * math.pi * soft_sign(follower_slip / WIDTH))


EFFECT = Effect(
    name="capstan",
    meaning="Wires rub on the pulleys they wrap, so the last fingers get less pull.",
    equation="T_out = T_in exp(-friction pi tanh(v / 5 mm/s)) at each pulley",
    source="Euler (1769) and Eytelwein (1808); Kaneko, Yamashita & Tanie (1991)",
    parameters=(Parameter("friction", 0.0, "1", (0.0, 0.5), "wire on pulley", off=0.0),),
    terms=(
        Term(along_leader, writes=("pull_a", "pull_b", "pull_thumb")),
        Term(over_cart, writes=("follower_loss",)),
    ),
)
