"""The lag of a measured motion behind its command: least squares on the velocities.

Both are interpolated on one grid and pass the same Savitzky-Golay derivative (Savitzky & Golay
1964), so the filter shifts neither against the other. The best whole step of their
cross-correlation starts a Gauss-Newton search between steps. The standard deviation takes the
residual as correlated in time (Newey & West 1987). It is the larger of two: with a stationary
residual, and with the residual as it stands. The lag includes the machine's own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

MOST_POINTS = 20_000  # of the common grid
SMOOTHED = 21  # grid points under one derivative
LEAST_CORRELATION = 0.5  # correlation below which nothing follows anything
AMBIGUOUS = 0.95  # a second maximum this near the best makes the lag ambiguous
ROUNDS = 20
STANDING = 0.02  # of both fastest speeds: a product below it is no motion together


@dataclass(frozen=True)
class Lag:
    """Lag of a motion [s], its standard deviation [s], and the fit of the two.

    correlation: correlation of the two velocities at this lag; gain: motion per command; against:
    share of the motion's squared speed while the command stands or goes the other way.
    """

    value: float
    deviation: float
    correlation: float
    gain: float
    against: float = 0.0


def time_apart(time: FloatArray, command_time: FloatArray) -> float:
    """Time between the end of one and the start of the other [s], below zero where they overlap."""
    return max(float(time[0] - command_time[-1]), float(command_time[0] - time[-1]))


@dataclass(frozen=True)
class _Speeds:
    """Velocities on a grid of `step` [s]; the command's reaches `margin` points further out.

    Both are shares of their fastest; `ratio` is the motion's fastest over the command's.
    """

    motion: FloatArray
    command: FloatArray
    ratio: float
    step: float
    margin: int


def lag_behind(
    time: FloatArray,
    motion: FloatArray,
    command_time: FloatArray,
    command: FloatArray,
    within: float = 1.0,
) -> Lag:
    """Return the lag of `motion` at `time` [s], shape (n,), behind `command`, shape (m,).

    The lag is searched between -`within` and +`within` [s]; the command holds its ends. Raises
    BadInput where nothing moves, nothing follows, or several lags fit equally well.
    """
    speeds = _speeds(time, motion, command_time, command, within)
    correlation = _correlation(speeds)
    best = int(np.argmax(correlation))
    _check(correlation, best, speeds)
    return _refined(speeds, float(best - speeds.margin))


def best_lag(
    time: FloatArray, motion: FloatArray, command_time: FloatArray, command: FloatArray
) -> Lag:
    """The best lag there is, however bad, wherever the two overlap; arrays as in `lag_behind`.

    Of several that fit equally well it is the one nearest to zero. Raises BadInput where one of
    the two stands still.
    """
    reach = float(time[-1] - time[0]) + float(command_time[-1] - command_time[0])
    apart = max(time_apart(time, command_time), 0.0)
    speeds = _speeds(time, motion, command_time, command, reach + apart)
    correlation = _correlation(speeds)
    peaks = _peaks(correlation, AMBIGUOUS * float(correlation.max()))
    best = min((abs(each - speeds.margin), each) for each in peaks)[1]
    return _refined(speeds, float(best - speeds.margin))


def _speeds(
    time: FloatArray,
    motion: FloatArray,
    command_time: FloatArray,
    command: FloatArray,
    within: float,
) -> _Speeds:
    span = float(time[-1] - time[0])
    step = max(float(np.median(np.diff(time))), (span + 2.0 * within) / MOST_POINTS)
    margin, points = round(within / step), round(span / step) + 1
    if points < 2 * SMOOTHED:
        raise BadInput(f"{points} points of {step:g} s are too few to align by")
    grid = time[0] + step * np.arange(-margin, points + margin)
    inner = slice(margin, margin + points)
    moved = _derivative(np.interp(grid[inner], time, motion), step)
    asked = _derivative(np.interp(grid, command_time, command), step)
    fastest = [float(np.abs(each).max()) for each in (moved, asked)]
    for what, speed in zip(("the motion", "the command"), fastest, strict=True):
        if not speed > 0.0:
            raise BadInput(f"{what} stands still: nothing to align by")
    ratio = fastest[0] / fastest[1]
    return _Speeds(moved / fastest[0], asked / fastest[1], ratio, step, margin)


def _derivative(values: FloatArray, step: float) -> FloatArray:
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(values, SMOOTHED, 2, deriv=1, delta=step))


def _correlation(speeds: _Speeds) -> FloatArray:
    """Normalised correlation for every whole lag from -margin to +margin."""
    from scipy.signal import correlate

    points = speeds.motion.size
    products = correlate(speeds.command, speeds.motion, "valid")[::-1]
    energy = np.concatenate(([0.0], np.cumsum(speeds.command**2)))
    windows = (energy[points:] - energy[:-points])[::-1]
    floor = 1e-12 * float(windows.max())
    size = float(np.linalg.norm(speeds.motion))
    return np.asarray(products / (size * np.sqrt(np.maximum(windows, floor))))


def _check(correlation: FloatArray, best: int, speeds: _Speeds) -> None:
    if correlation[best] < LEAST_CORRELATION:
        against = correlation.min() < -LEAST_CORRELATION
        advice = "is its sign reversed?" if against else "are both of one run?"
        raise BadInput(
            "the motion does not follow the command "
            f"(correlation {correlation[best]:.2f} at best): {advice}"
        )
    if best in (0, correlation.size - 1) and correlation.size > 1:
        reach = speeds.margin * speeds.step
        raise BadInput(f"the best lag lies beyond {reach:g} s: search a wider range (within)")
    peaks = _peaks(correlation, AMBIGUOUS * correlation[best])
    if len(peaks) > 1:
        lags = ", ".join(f"{(each - speeds.margin) * speeds.step:.4g} s" for each in peaks[:4])
        raise BadInput(f"several lags fit equally well ({lags}): search a narrower range (within)")


def _peaks(correlation: FloatArray, level: float) -> list[int]:
    """Best place of every separate run above `level`."""
    above = np.flatnonzero(correlation > level)
    runs = np.split(above, np.flatnonzero(np.diff(above) > 1) + 1)
    return [int(each[np.argmax(correlation[each])]) for each in runs]


def _refined(speeds: _Speeds, start: float) -> Lag:
    """Gauss-Newton on lag (in steps) and gain from the best whole step."""
    points = np.arange(speeds.motion.size, dtype=float)
    slopes = np.gradient(speeds.command)
    lag = start
    for _ in range(ROUNDS):
        at = points + speeds.margin - lag
        follows, slope = _at(speeds.command, at), _at(slopes, at)
        gain = float(follows @ speeds.motion / (follows @ follows))
        rest = speeds.motion - gain * follows
        change = -gain * slope  # of the model, per step of lag
        free = change - follows * float(follows @ change / (follows @ follows))
        move = float(np.clip(free @ rest / (free @ free), -1.0, 1.0))
        lag = float(np.clip(lag + move, -speeds.margin, speeds.margin))
        if abs(move) < 1e-6:
            break
    spread = max(_series_variance(free * rest), _stationary_variance(free, rest))
    deviation = speeds.step * float(np.sqrt(spread)) / float(free @ free)
    correlation = float(follows @ speeds.motion) / float(
        np.linalg.norm(follows) * np.linalg.norm(speeds.motion)
    )
    against = _against(speeds.motion, follows)
    return Lag(lag * speeds.step, deviation, correlation, gain * speeds.ratio, against)


def _against(motion: FloatArray, command: FloatArray) -> float:
    """Share of the motion's squared speed while the command stands or goes the other way.

    A motion that is blocked, or ends early, moves with its command for as long as it moves.
    """
    least = STANDING * float(np.abs(motion).max()) * float(np.abs(command).max())
    return float(np.sum(motion[motion * command <= least] ** 2) / np.sum(motion**2))


def _at(values: FloatArray, places: FloatArray) -> FloatArray:
    return np.interp(places, np.arange(values.size), values)


def _series_variance(series: FloatArray) -> float:
    """Variance of the sum of a correlated series, by its own autocovariance."""
    products = _products(series - series.mean())
    return float(max(products[0], 2.0 * _weights(products) @ products - products[0]))


def _stationary_variance(free: FloatArray, rest: FloatArray) -> float:
    """Variance of the sum of free * rest, were rest stationary and correlated."""
    covariance = _products(rest - rest.mean()) / rest.size
    terms = _weights(covariance) * covariance * _products(free)
    return float(max(0.0, 2.0 * terms.sum() - terms[0]))


def _products(values: FloatArray) -> FloatArray:
    """Sums of products of a series with itself, 0, 1, 2, ... places later."""
    from scipy.signal import correlate

    return np.asarray(correlate(values, values, "full")[values.size - 1 :])


def _weights(products: FloatArray) -> FloatArray:
    """Bartlett weights over twice the time to the first zero of the autocovariance."""
    ended = np.flatnonzero(products <= 0.0)
    memory = 2 * max(int(ended[0]) if ended.size else products.size // 4, SMOOTHED)
    return np.maximum(0.0, 1.0 - np.arange(products.size) / memory)
