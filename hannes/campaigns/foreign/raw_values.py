"""Raw numbers put right: signs of integers, counters that begin anew, stamps out of order."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def signed(values: FloatArray, bits: int) -> FloatArray:
    """Two's complement of integers of `bits` that were read as unsigned; NaN stays."""
    return np.where(values >= 2.0 ** (bits - 1), values - 2.0**bits, values)


def unwrapped(values: FloatArray, turn: float) -> FloatArray:
    """A counter of which every jump by more than half a `turn` is one turn less; NaN stays."""
    known = np.isfinite(values)
    found = values.copy()
    found[known] = np.unwrap(values[known], period=turn)
    return found


def forward(ticks: FloatArray, turn: float) -> FloatArray:
    """A clock that begins anew after `turn` ticks, and never goes back otherwise; NaN stays."""
    known = np.isfinite(ticks)
    found = ticks.copy()
    steps = np.diff(ticks[known])
    found[known] += turn * np.concatenate(([0.0], np.cumsum(steps < 0.0)))
    return found


def in_order(
    time: FloatArray, columns: dict[str, FloatArray], rows: NDArray[np.intp], order: str
) -> tuple[FloatArray, dict[str, FloatArray], NDArray[np.intp]]:
    """Strictly increasing times with their columns and rows, all (n,), by one of ORDERS.

    drop: what does not come after all before it goes; sort: by time, of doubled ones the first;
    mean: by time, of doubled ones the mean. `refuse` leaves all as it is.
    """
    if order == "refuse":
        return time, columns, rows
    if order == "drop":
        latest = np.concatenate(([-np.inf], np.maximum.accumulate(time)[:-1]))
        kept = np.flatnonzero(time > latest)
        return time[kept], {name: x[kept] for name, x in columns.items()}, rows[kept]
    times, first, places = np.unique(time, return_index=True, return_inverse=True)
    if order == "sort":
        return times, {name: x[first] for name, x in columns.items()}, rows[first]
    counts = np.bincount(places)
    means = {name: np.bincount(places, weights=x) / counts for name, x in columns.items()}
    return times, means, rows[first]


def restarts(time: FloatArray) -> NDArray[np.intp]:
    """Rows at which a clock begins anew: it goes back by more than half of what had passed.

    A stamp that is only out of order goes back a little, and comes back.
    """
    latest, start, found = -np.inf, 0.0, []
    for row, now in enumerate(time):
        if not np.isfinite(now):
            continue
        if latest == -np.inf:
            latest = start = now
        elif now < latest and latest - now > 0.5 * (latest - start):
            if row + 1 >= time.size or not time[row + 1] > latest:
                found.append(row)
                latest = start = now
        latest = max(latest, now)
    return np.array(found, np.intp)


def readings(values: FloatArray, period: int) -> FloatArray:
    """Values in the rows of a channel's readings, NaN in those that only repeat them.

    A reading comes every `period` rows, in the rows in which most changes are.
    """
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    phase = int(np.bincount(changes % period, minlength=period).argmax()) if changes.size else 0
    return np.where(np.arange(values.size) % period == phase, values, np.nan)


def disorder(time: FloatArray) -> tuple[str, str]:
    """What is wrong with times that do not increase, and the mapping's line that mends it."""
    steps = np.diff(time)
    forth = steps[steps > 0.0]
    if restarts(time).size:
        return "several runs in one file, whose clock begins anew", 'split_at = "restart"'
    if np.mean(steps == 0.0) > COARSE and forth.size:
        rate = roundest(float((time.size - 1) / (time[-1] - time[0])), forth.min() / np.ptp(time))
        what = (
            f"the clock is too coarse, {forth.min():.4g} s a step; by its ends it is {rate:.5g} Hz"
        )
        return what, f'time.sampling = "{rate:.6g} Hz"'
    if rate := _set_back(steps):
        return "the clock was set back, and rows go on", f'time.sampling = "{rate:.7g} Hz"'
    if (steps < 0.0).any():
        return "rows are out of order", 'time.order = "sort"'
    return "stamps are doubled", 'time.order = "drop"'


def usual_rate(rate: float, doubt: float) -> float | None:
    """The sampling rate within a relative doubt that loggers use [Hz], None where there is none."""
    decade = 10.0 ** np.floor(np.log10(rate))
    near = [lead * decade for lead in USUAL if abs(lead * decade / rate - 1.0) < doubt]
    return float(near[0]) if near else None


USUAL = (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0)  # leading digits of sampling rates


def roundest(rate: float, doubt: float) -> float:
    """The roundest rate [Hz], or that of the roundest interval, within a relative doubt."""
    for digits in (1, 2, 3):
        for near in (float(f"{rate:.{digits}g}"), 1.0 / float(f"{1.0 / rate:.{digits}g}")):
            if abs(near / rate - 1.0) < doubt:
                return near
    return rate


def _set_back(steps: FloatArray) -> float:
    """Rate of rows whose clock was set back a few times [Hz], 0 where it was not.

    Rows out of order are followed by longer intervals; after a clock that was set all goes on.
    """
    usual = float(np.median(steps))
    back = np.flatnonzero(steps <= 0.0)
    if usual <= 0.0 or back.size > MOST_SET or not (steps < 0.0).any():
        return 0.0
    near = steps[np.clip(back[:, None] + np.array([-2, -1, 1, 2]), 0, steps.size - 1)]
    return 1.0 / usual if (np.abs(near / usual - 1.0) < 0.5).all() else 0.0


MOST_SET = 3  # times that a clock is set within a file
COARSE = 0.4  # share of equal stamps from which a clock is too coarse


def motor_current(supply: FloatArray, duty: FloatArray) -> FloatArray:
    """Current in the winding of a current drawn from the supply: i_supply = |duty| i_motor.

    Losses of the bridge are left out. NaN where the duty is too small.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.abs(duty) > LEAST_DUTY, supply / duty, np.nan)


LEAST_DUTY = 0.02
