"""White-noise level of a signal, whatever moves slowly in it."""

import math
import weakref
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np

DEVIATION = 1.4826  # of a normal distribution, over its median absolute value
ALTERNATES = 0.55  # share of sign changes that separates noise from curvature
FEWEST_SIGNS = 10
ROUNDING = 1e-7  # of the range; less is the rounding of digits
FINEST = 1e-5  # of the range; a smaller quantisation step is ignored
SECOND = 6.0  # variance of white noise's second difference, 1 + 4 + 1, over its own


T = TypeVar("T", int, float, np.ndarray)
_KNOWN: dict[tuple[int, str], tuple[Any, Any]] = {}


def remembered(function: Callable[[np.ndarray], T]) -> Callable[[np.ndarray], T]:
    """Compute once for each array that cannot change, as channels of recordings are."""

    @wraps(function)
    def call(values: np.ndarray) -> T:
        if values.flags.writeable or values.base is not None:
            return function(values)
        key = (id(values), function.__name__)
        known = _KNOWN.get(key)
        if known is None or known[0]() is not values:
            gone = weakref.ref(values, lambda _: _KNOWN.pop(key, None))
            known = _KNOWN[key] = (gone, function(values))
        return cast(T, known[1])

    return call


def roughness(samples: np.ndarray) -> float:
    """Standard deviation of samples [their unit], shape (n >= 3,), were their noise white.

    By the median absolute second difference: a straight line adds nothing, rare jumps little.
    """
    return DEVIATION * float(np.median(np.abs(np.diff(samples, 2)))) / math.sqrt(SECOND)


@remembered
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


@remembered
def levels(values: np.ndarray) -> int:
    """How many different values there are."""
    return int(_distinct(values).size)


@remembered
def _distinct(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.unique(values))


@remembered
def quantum(values: np.ndarray) -> float:
    """Quantisation step, 0 where none is visible."""
    levels = _distinct(values)
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


def rounding(values: np.ndarray) -> float:
    """Step of a coarse sensor, of one with two levels too; 0 where none is visible."""
    return float(np.ptp(values)) if levels(values) == 2 else quantum(values)
