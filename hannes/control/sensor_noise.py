"""Noise of a sampled sensor: a number for every tick, the same whenever the tick is run again."""

import math

from hannes.core.kernels.jit import kernel

PRIME = 2147483647  # 2^31 - 1: squares of what is below it are whole numbers of 64 bits
FARTHEST = 256  # ticks back that a filter remembers
LEAST = 0.02  # weight of the farthest, over that of the first


@kernel
def scrambled(number):
    """Another whole number below PRIME: a polynomial of degree 16 (Lidl & Niederreiter 1997)."""
    for _ in range(4):
        number = (number * number + 1013904223) % PRIME
    return number


@kernel
def gaussian(seed, tick):
    """Standard normal number (Box & Muller 1958); seed and tick are whole numbers from 0 on."""
    start = (seed * 69621 + tick * 1566083941 + 12345) % PRIME
    one = (scrambled(start) + 1.0) / (PRIME + 1.0)
    other = scrambled((start + 97003) % PRIME) / PRIME
    return math.sqrt(-2.0 * math.log(one)) * math.cos(2.0 * math.pi * other)


@kernel
def coloured(seed, tick, bandwidth, period):
    """The same of a first-order autoregression with variance 1: white noise through such a filter.

    bandwidth: Hz, 0 for white;  period: s, of ticks. Source: Box, Jenkins & Reinsel (2008), 3.2.
    """
    if bandwidth <= 0.0:
        return gaussian(seed, tick)
    keep = math.exp(-2.0 * math.pi * bandwidth * period)
    weight, total, squares, back = 1.0, 0.0, 0.0, 0
    while back < FARTHEST and weight > LEAST:
        total += weight * gaussian(seed, tick + FARTHEST - back)
        squares += weight * weight
        weight *= keep
        back += 1
    return total / math.sqrt(squares)
