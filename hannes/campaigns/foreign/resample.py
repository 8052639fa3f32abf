"""Resampling onto an even clock: means for a lower rate, linear interpolation for a higher one."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

GAP = 2.5  # median intervals; a longer interval stays a gap
MOST_SAMPLES = 50_000_000


def resampled(
    time: FloatArray, channels: Mapping[str, FloatArray], rate: float
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return times at whole multiples of 1/`rate` [Hz] and the channels there, shape (m,).

    For a lower rate, each sample is the mean of the linear interpolation over its interval, so that
    noise above half the new rate does not alias. For a higher rate, it is the interpolation itself.
    Raises BadInput for fewer than two samples, or too many.
    """
    step = 1.0 / rate
    first, last = np.ceil(time[0] / step - 1e-9), np.floor(time[-1] / step + 1e-9)
    if not 1 <= last - first < MOST_SAMPLES:
        raise BadInput(
            f"time.resample = {rate:g} Hz makes {max(last - first + 1, 0):.0f} samples of "
            f"{time[-1] - time[0]:g} s; expected 2 to {MOST_SAMPLES}"
        )
    grid = step * np.arange(first, last + 1)
    grid = grid[_recorded(time, grid)]
    typical = float(np.median(np.diff(time)))
    if step > 1.01 * typical:
        return grid, {name: _means(time, x, grid, step) for name, x in channels.items()}
    return grid, {name: np.interp(grid, time, x) for name, x in channels.items()}


def _recorded(time: FloatArray, grid: FloatArray) -> NDArray[np.bool_]:
    """Mask of grid times that do not lie inside a gap."""
    intervals = np.diff(time)
    after = np.clip(np.searchsorted(time, grid, side="right"), 1, time.size - 1)
    wide = intervals[after - 1] > GAP * np.median(intervals)
    near = np.minimum(np.abs(grid - time[after - 1]), np.abs(time[after] - grid))
    return ~wide | (near <= 1e-9 * np.maximum(np.abs(grid), 1.0))


def _means(time: FloatArray, values: FloatArray, grid: FloatArray, step: float) -> FloatArray:
    """Mean of the straight lines through the samples over `step` around each grid time."""
    area = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))))

    def integral(at: FloatArray) -> FloatArray:
        at = np.clip(at, time[0], time[-1])
        k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
        part = at - time[k]
        slope = (values[k + 1] - values[k]) / (time[k + 1] - time[k])
        return area[k] + part * (values[k] + 0.5 * part * slope)

    low, high = np.maximum(grid - 0.5 * step, time[0]), np.minimum(grid + 0.5 * step, time[-1])
    return np.asarray((integral(high) - integral(low)) / (high - low))
