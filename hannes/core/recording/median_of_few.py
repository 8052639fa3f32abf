"""Median of three or five neighbouring samples, by comparisons of whole arrays.

Several times quicker than a filter that sorts every window (networks of Devillard 1998).
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def median_of_three(values: FloatArray) -> FloatArray:
    """Median of each sample and both beside it, shape (n,); the ends are repeated."""
    before, here, after = _shifted(values, 1)
    low, high = np.minimum(before, here), np.maximum(before, here)
    return np.maximum(low, np.minimum(high, after))


def median_of_five(values: FloatArray) -> FloatArray:
    """Median of each sample and two on either side, shape (n,); the ends are repeated."""
    a, b, middle, c, d = _shifted(values, 2)
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))  # at least two are no more than that
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))  # and two no less than that
    least, most = np.minimum(low, high), np.maximum(low, high)
    return np.maximum(least, np.minimum(most, middle))


def _shifted(values: FloatArray, reach: int) -> list[FloatArray]:
    padded = np.pad(np.asarray(values, float), reach, mode="edge")
    return [padded[k : k + values.size] for k in range(2 * reach + 1)]
