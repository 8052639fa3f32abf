"""The paper's figures of merit, with the definitions the paper leaves open.

Currents enter by magnitude, sampled at 1 kHz and smoothed by an 11 ms centred mean.
"""

from dataclasses import dataclass

import numpy as np

DEFINITIONS = {
    "contact": "first total force above 1 N",
    "I_avgc": "mean current from 0.02 s to contact",
    "I_avgo": "mean current from release to the motor's return to 10 % of its peak position",
    "I_max": "peak current",
    "I_sc": "least-squares slope between the last upward crossings of 20 and 80 % of the way "
    "from I_avgc to I_max",
    "I_so": "least-squares slope between the first downward crossings of 80 and 20 % of I_max "
    "after the peak",
    "F_max": "peak of the sum of the phalanges' normal forces",
    "void current": "mean current over 0.15-0.30 s of a free closure",
    "closing time": "time to 90 % of the furthest position of a free closure",
}


@dataclass(frozen=True)
class GraspMetrics:
    """Table II's figures of one grasp: times in s, currents in A, slopes in A/s, force in N."""

    contact: float
    release: float
    I_avgc: float
    I_avgo: float
    I_max: float
    I_sc: float
    I_so: float
    F_max: float


def smoothed(current: np.ndarray, sampling: float = 1000.0) -> np.ndarray:
    """Magnitude of the current after an 11 ms centred mean, same shape."""
    width = max(1, round(0.011 * sampling)) | 1
    padded = np.pad(np.abs(current), width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), "valid")


def grasp_metrics(
    time: np.ndarray, current: np.ndarray, force: np.ndarray, position: np.ndarray
) -> GraspMetrics:
    """Measure one grasp; arrays of shape (n,) in s, A, N, rad. NaN where a figure has no sense."""
    size = smoothed(current, 1.0 / (time[1] - time[0]))
    touching = np.flatnonzero(force > 1.0)
    if touching.size == 0:
        return GraspMetrics(*[np.nan] * 8)
    first, last, peak = touching[0], touching[-1], int(np.argmax(size))
    closing = size[(time >= 0.02) & (time < time[first])].mean() if time[first] > 0.02 else np.nan
    back = np.flatnonzero((position < 0.1 * position.max()) & (np.arange(time.size) > last))
    opening = size[last : back[0]].mean() if back.size else np.nan
    let_go = last + 1 < time.size
    return GraspMetrics(
        float(time[first]),
        float(time[last]) if let_go else np.nan,
        float(closing),
        float(opening),
        float(size[peak]),
        _rising_slope(time, size, peak, float(closing)),
        falling_slope(time, size),
        float(force.max()),
    )


def _rising_slope(time: np.ndarray, size: np.ndarray, peak: int, closing: float) -> float:
    low = closing + 0.2 * (size[peak] - closing)
    high = closing + 0.8 * (size[peak] - closing)
    below_low = np.flatnonzero(size[: peak + 1] < low)
    below_high = np.flatnonzero(size[: peak + 1] < high)
    if below_low.size == 0 or below_high.size == 0:
        return float("nan")
    return _slope(time, size, below_low[-1], below_high[-1])


def falling_slope(time: np.ndarray, size: np.ndarray) -> float:
    """I_so [A/s] of a smoothed magnitude of the current [A] over time [s], shape (n,); or NaN."""
    peak = int(np.argmax(size))
    after = size[peak:]
    under_high = np.flatnonzero(after < 0.8 * size[peak])
    under_low = np.flatnonzero(after < 0.2 * size[peak])
    if under_high.size == 0 or under_low.size == 0:
        return float("nan")
    return _slope(time, size, peak + under_high[0], peak + under_low[0])


def _slope(time: np.ndarray, size: np.ndarray, start: int, end: int) -> float:
    if end - start < 2:
        return float("nan")
    part = slice(start, end + 1)
    return float(np.polyfit(time[part], size[part], 1)[0])


def void_current(time: np.ndarray, current: np.ndarray) -> float:
    """Mean current [A] over 0.15-0.30 s of a free closure."""
    size = smoothed(current, 1.0 / (time[1] - time[0]))
    return float(size[(time >= 0.15) & (time <= 0.30)].mean())


def closing_time(time: np.ndarray, position: np.ndarray) -> float:
    """Time [s] to 90 % of the furthest position of a free closure, between samples.

    NaN where it begins there.
    """
    level = 0.9 * position.max()
    after = int(np.argmax(position >= level))
    pair = slice(after - 1, after + 1)
    return float(np.interp(level, position[pair], time[pair])) if after else float("nan")


def relative_error(hannes: float, model: float) -> float:
    """Equation 4 of the paper, with its sign: 100 (hannes - model) / hannes [%]."""
    return 100.0 * (hannes - model) / hannes
