"""Elementary functions as straight-line arithmetic.

A call of the C library keeps a loop from being worked on several elements at a time, and what
stands around it from staying in registers; these do not.
"""

import math

import numpy as np

from hannes.core.kernels.jit import fused, kernel, power_of_two

FAR = 40.0  # where exp(-x) is below the last digit of 1
PER_DOUBLING = 1.0 / math.log(2.0)
DOUBLING, LACK = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # log 2 in two parts
WHOLE = 1.5 * 2.0**52  # to which added a number loses what is not whole


@kernel
def exp_minus_one(x):
    """exp(x) - 1 for x <= 700, to 1e-15 of itself: 2^k exp(t) - 1, and exp(t) - 1 a series."""
    bounded = max(x, -FAR)
    k = fused(bounded, PER_DOUBLING, WHOLE) - WHOLE
    t = fused(-k, LACK, fused(-k, DOUBLING, bounded))
    q = t * t
    r = q * q
    low = fused(q, fused(t, 1.0 / 120.0, 1.0 / 24.0), fused(t, 1.0 / 6.0, 1.0 / 2.0))
    middle = fused(t, 1.0 / 5040.0, 1.0 / 720.0)
    middle = fused(q, fused(t, 1.0 / 362880.0, 1.0 / 40320.0), middle)
    high = fused(t, 1.0 / 39916800.0, 1.0 / 3628800.0)
    high = fused(q, fused(t, 1.0 / 6227020800.0, 1.0 / 479001600.0), high)
    series = fused(q, fused(r, fused(r, high, middle), low), t)
    scale = power_of_two(k)
    return fused(scale, series, scale - 1.0)


@kernel
def soft_sign(x):
    """tanh(x), to 1e-15 of itself."""
    g = exp_minus_one(-2.0 * abs(x))
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
