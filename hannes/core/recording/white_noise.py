"""White-noise level of a signal, whatever moves slowly in it."""

import math

import numpy as np

DEVIATION = 1.4826  # of a normal distribution, over its median absolute value
SECOND = 6.0  # variance of white noise's second difference, 1 + 4 + 1, over its own


def roughness(samples: np.ndarray) -> float:
    """Standard deviation of samples [their unit], shape (n >= 3,), were their noise white.

    By the median absolute second difference: a straight line adds nothing, rare jumps little.
    """
    return DEVIATION * float(np.median(np.abs(np.diff(samples, 2)))) / math.sqrt(SECOND)
