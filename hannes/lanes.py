"""Elementary functions as straight-line arithmetic, for loops over joints and phalanges.

A call of the C library keeps a loop from being worked on several elements at a time; these do
not (nor may they divide, which is slow). For a single number the library's functions are faster.
"""

import math

import numpy as np

from hannes._jit import fused, kernel

FAR = 40.0  # where exp(-x) is below the last digit of 1


@kernel
def faded(x):
    """exp(-x) - 1 for x >= 0, to 1e-15 of itself: seven doublings of a series."""
    t = min(x, FAR) * (-1.0 / 128.0)
    q = t * t
    low = fused(q, fused(t, 1.0 / 24.0, 1.0 / 6.0), fused(t, 1.0 / 2.0, 1.0))
    middle = fused(t, 1.0 / 720.0, 1.0 / 120.0)
    middle = fused(q, fused(t, 1.0 / 40320.0, 1.0 / 5040.0), middle)
    high = fused(q, 1.0 / 39916800.0, fused(t, 1.0 / 3628800.0, 1.0 / 362880.0))
    g = t * fused(q * q, fused(q * q, high, middle), low)
    g *= 2.0 + g
    g *= 2.0 + g
    g *= 2.0 + g
    g *= 2.0 + g
    g *= 2.0 + g
    g *= 2.0 + g
    g *= 2.0 + g
    return g


@kernel
def lane_sign(x):
    """tanh(x), to 1e-14 of itself."""
    g = faded(2.0 * abs(x))
    return math.copysign(g / (2.0 + g), x)


@kernel
def direction(angle):
    """Cosine and sine, within a turn to 1e-15: series at a quarter of the angle, doubled twice."""
    turns = np.floor(angle * (0.5 / math.pi) + 0.5)  # math's refuses what is no number
    t = 0.25 * fused(-2.0 * math.pi, turns, angle)
    q = t * t
    r = q * q
    low = fused(q, 1.0 / 120.0, -1.0 / 6.0)
    middle = fused(q, 1.0 / 362880.0, -1.0 / 5040.0)
    high = fused(q, 1.0 / 6227020800.0, -1.0 / 39916800.0)
    high = fused(r, -1.0 / 1307674368000.0, high)
    sine = fused(t * q, fused(r, fused(r, high, middle), low), t)
    low = fused(q, 1.0 / 24.0, -1.0 / 2.0)
    middle = fused(q, 1.0 / 40320.0, -1.0 / 720.0)
    high = fused(q, 1.0 / 479001600.0, -1.0 / 3628800.0)
    high = fused(r, fused(q, 1.0 / 20922789888000.0, -1.0 / 87178291200.0), high)
    cosine = fused(q, fused(r, fused(r, high, middle), low), 1.0)
    twice = 2.0 * sine * cosine
    double = 2.0 * twice
    return fused(-double, twice, 1.0), double * fused(-2.0 * sine, sine, 1.0)
