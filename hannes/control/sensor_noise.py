"""Noise of a sampled sensor: a number for every tick, the same whenever the tick is run again."""

import math

from hannes.core.kernels.jit import kernel

PRIME = 2147483647  # 2^31 - 1: squares of what is below it are whole numbers of 64 bits


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
