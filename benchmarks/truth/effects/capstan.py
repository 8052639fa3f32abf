"""Capstan friction (Euler-Eytelwein) where a wire runs over a pulley.

    T_out = T_in exp(-friction wrap tanh(v / v_s)),  wrap = pi, v_s = 5 mm/s

T_in: on the motor's side; v > 0 where the wire runs towards the motor (closing). The leader runs
over cart A's pulley, the fixed return and cart B's pulley, at speeds relative to each pulley of

    v_A = x_A' + 2 x_B' + l_thumb',  v_R = 2 x_B' + l_thumb',  v_B = x_B' + l_thumb'

The elastic law gives T_0 at the motor pulley, and T_1, T_2, T_3 follow; cart A is pulled by
T_0 + T_1, cart B by T_2 + T_3, the thumb by T_3. Each follower runs over its cart's pulley from its
first finger towards its second at v = (l_1' - l_2') / 2; about the mean T_F of the elastic law

    T_1 = T_F (1 - tanh(c/2)), T_2 = T_F (1 + tanh(c/2)),  c = friction wrap tanh(v / v_s)

which is T_2 = T_1 exp(c) with the pull on the cart unchanged.
Source: Euler (1769), Eytelwein (1808); Kaneko et al. (1991) for tendon drives. Range: ball bearings
(0.003) to polyethylene fibre on dry metal (0.15).
"""

from math import exp, pi, tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.size import Size

SIZES = {"friction": Size("1", 0.003, 0.15)}
SLIDE_SPEED = 5e-3  # m/s


@compiled
def passed(h, tension, speed):
    """Tension (N) behind a half turn over which the wire runs with `speed` (m/s)."""
    if h.capstan_friction == 0.0:
        return tension
    return tension * exp(-h.capstan_friction * pi * tanh(speed / SLIDE_SPEED))


@compiled
def shared(h, tension, speed):
    """Tensions (N) of a follower's two ends about their mean, the wire running to the second."""
    if h.capstan_friction == 0.0:
        return tension, tension
    part = tanh(0.5 * h.capstan_friction * pi * tanh(speed / SLIDE_SPEED))
    return tension * (1.0 - part), tension * (1.0 + part)
