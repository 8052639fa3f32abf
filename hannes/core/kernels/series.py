"""Smooth laws of one quantity by few numbers: Legendre's polynomials and Fourier's cosines."""

import math

from hannes.core.kernels.jit import kernel


@kernel
def placed(value, low, high):
    """A value's place in a range, -1 at its low end and 1 at its high end; constant beyond."""
    return min(max(2.0 * (value - low) / (high - low) - 1.0, -1.0), 1.0)


@kernel
def legendre(x, c_0, c_1, c_2, c_3, c_4):
    """c_0 + c_1 P_1(x) + ... + c_4 P_4(x), in the coefficients' unit."""
    q = x * x
    even = c_2 * (1.5 * q - 0.5) + c_4 * (q * (4.375 * q - 3.75) + 0.375)
    return c_0 + even + x * (c_1 + c_3 * (2.5 * q - 1.5))


@kernel
def cosines(share, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Sum of c_k cos(k pi share), at a share of a range: mirrored beyond."""
    x = math.cos(math.pi * share)
    t_2 = 2.0 * x * x - 1.0
    t_3 = 2.0 * x * t_2 - x
    t_4 = 2.0 * t_2 * t_2 - 1.0
    t_5 = 2.0 * x * t_4 - t_3
    t_6 = 2.0 * t_3 * t_3 - 1.0
    return c_0 + c_1 * x + c_2 * t_2 + c_3 * t_3 + c_4 * t_4 + c_5 * t_5 + c_6 * t_6


@kernel
def cosines_from_zero(share, c_1, c_2, c_3, c_4, c_5, c_6):
    """The same less its value at 0."""
    whole = c_1 + c_2 + c_3 + c_4 + c_5 + c_6
    return cosines(share, -whole, c_1, c_2, c_3, c_4, c_5, c_6)
