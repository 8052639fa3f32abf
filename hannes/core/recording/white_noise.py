"""White-noise level of a signal, whatever moves slowly in it."""

import math

import numpy as np

DEVIATION = 1.4826  # of a normal distribution, over its median absolute value
ALTERNATES = 0.55  # share of sign changes that separates noise from curvature
FEWEST_SIGNS = 10
ROUNDING = 1e-7  # of the range; less is the rounding of digits
FINEST = 1e-5  # of the range; a smaller quantisation step is ignored
SECOND = 6.0  # variance of white noise's second difference, 1 + 4 + 1, over its own


def roughness(samples: np.ndarray) -> float:
    """Standard deviation of samples [their unit], shape (n >= 3,), were their noise white.

    By the median absolute second difference: a straight line adds nothing, rare jumps little.
    """
    return DEVIATION * float(np.median(np.abs(np.diff(samples, 2)))) / math.sqrt(SECOND)


def noise(values: np.ndarray) -> float:
    """Standard deviation of white noise from second differences; 0 for a smooth signal.

    The second difference of white noise changes sign 73 times in 100 samples (its correlation
    from one to the next is -2/3), that of a smooth signal hardly ever.
    """
    second = np.diff(values, 2)
    signs = np.sign(second[second != 0.0])
    if signs.size < FEWEST_SIGNS or np.mean(signs[1:] != signs[:-1]) < ALTERNATES:
        return 0.0
    size = roughness(values)
    return size if size > ROUNDING * float(np.ptp(values)) else 0.0


def quantum(values: np.ndarray) -> float:
    """Quantisation step, 0 where none is visible."""
    levels = np.unique(values)
    if levels.size < 3:
        return 0.0
    span = float(levels[-1] - levels[0])
    gaps = np.diff(levels)
    gaps = gaps[gaps > FINEST * span]
    if gaps.size < 2:
        return 0.0
    multiples = gaps / gaps.min()
    off = np.abs(multiples - np.round(multiples)) > 0.05
    return float(np.median(gaps / np.round(multiples))) if off.mean() < 0.01 else 0.0
