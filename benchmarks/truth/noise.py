"""Noise of the current sensor: white, or of a stated bandwidth.

    e_k = a e_(k-1) + sqrt(1 - a^2) n_k,   a = exp(-2 pi f / f_s)

n: white; f: bandwidth; f_s: rate of samples. A first-order autoregression is what a first-order
filter before the converter leaves of white noise. Its RMS is the same at any bandwidth.
Source: Box, Jenkins & Reinsel (2008), section 3.2.
"""

import numpy as np

from benchmarks.truth.bench import CURRENT

RATE = 1000.0  # Hz


def current_noise(
    rng: np.random.Generator, samples: int, bandwidth: float | None = None
) -> np.ndarray:
    """Noise (A) of so many samples; bandwidth: Hz, white where None."""
    white = rng.standard_normal(samples)
    if bandwidth is None:
        return CURRENT * white
    from scipy.signal import lfilter

    keep = np.exp(-2.0 * np.pi * bandwidth / RATE)
    white[1:] *= np.sqrt(1.0 - keep**2)
    return CURRENT * lfilter([1.0], [1.0, -keep], white)
