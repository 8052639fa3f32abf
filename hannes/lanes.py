"""Elementary functions as straight-line arithmetic, for loops over joints and phalanges.

A call of the C library keeps a loop from being worked on eight elements at a time; these do
not (nor may they divide, which is slow). For a single number the library's functions are faster.
"""

import math

import numpy as np

from hannes._jit import kernel

FAR = 40.0  # where exp(-x) is below the last digit of 1


@kernel
def faded(x):
    """exp(-x) - 1 for x >= 0, to 1e-15 of itself: seven doublings of a series."""
    t = min(x, FAR) * (-1.0 / 128.0)
    q = t * t
    low = (1.0 + t * (1.0 / 2.0)) + q * (1.0 / 6.0 + t * (1.0 / 24.0))
    middle = (1.0 / 120.0 + t * (1.0 / 720.0)) + q * (1.0 / 5040.0 + t * (1.0 / 40320.0))
    high = 1.0 / 362880.0 + t * (1.0 / 3628800.0) + q * (1.0 / 39916800.0)
    g = t * (low + q * q * (middle + q * q * high))
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
    """Cosine and sine, to 1e-15: series at a quarter of the angle, doubled twice."""
    turns = np.floor(angle / (2.0 * math.pi) + 0.5)  # math's refuses what is no number
    t = 0.25 * (angle - 2.0 * math.pi * turns)
    q = t * t
    high = 1.0 - q * (1.0 / 110.0) * (1.0 - q * (1.0 / 156.0) * (1.0 - q * (1.0 / 210.0)))
    high = 1.0 - q * (1.0 / 20.0) * (1.0 - q * (1.0 / 42.0) * (1.0 - q * (1.0 / 72.0) * high))
    sine = t * (1.0 - q * (1.0 / 6.0) * high)
    high = 1.0 - q * (1.0 / 182.0) * (1.0 - q * (1.0 / 240.0))
    high = 1.0 - q * (1.0 / 90.0) * (1.0 - q * (1.0 / 132.0) * high)
    high = 1.0 - q * (1.0 / 12.0) * (1.0 - q * (1.0 / 30.0) * (1.0 - q * (1.0 / 56.0) * high))
    cosine = 1.0 - q * (1.0 / 2.0) * high
    twice = 2.0 * sine * cosine
    return 1.0 - 2.0 * twice * twice, 2.0 * twice * (1.0 - 2.0 * sine * sine)
