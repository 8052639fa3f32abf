"""A smooth law of one quantity by few numbers: Legendre's polynomials over its range."""

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
