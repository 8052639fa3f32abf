"""Rows in which a logger wrote its last frame again, as opposed to a machine at rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.core.recording.white_noise import noise, quantum

FloatArray = NDArray[np.float64]

MOTIONS = ("rad", "m", "deg", "mm")  # units of positions, which inertia keeps from leaping
FEWEST = 3  # repeated samples that are no chance
AROUND = 6  # fresh samples on each side by which a channel is seen to go on
STEPS = 2.0  # of a channel's steps a sample: it cannot repeat itself
LEAP = 4.0  # of its steps, by which a motion that was held leaps at the end
AT_ONCE, AT_MOST = 2.5, 4.0  # times a following step, and times what was missed, of that leap


def held_rows(
    channels: Sequence[FloatArray], smooth: Sequence[bool] = ()
) -> NDArray[np.bool_]:  # fmt: skip
    """Whether each row repeats all of several measured channels though it should not, (n,).

    A machine at rest, or at its turn, repeats itself rightly: repeats count where a channel before
    and after them goes on by several of its steps, or where a `smooth` one, which inertia keeps
    from leaping, leaps by what it missed. So rest is never taken for a doubled row.
    """
    marks = [*smooth, *(False for _ in channels[len(smooth) :])]
    moving = [
        (x, mark) for x, mark in zip(channels, marks, strict=True) if np.nanmax(x) > np.nanmin(x)
    ]
    same = np.zeros(channels[0].size if channels else 0, np.bool_)
    if len(moving) < 2:
        return same
    same[1:] = np.all([np.diff(each) == 0.0 for each, _ in moving], axis=0)
    fresh = np.flatnonzero(~same)
    first = np.flatnonzero(same & ~np.concatenate(([True], same[:-1])))
    if not first.size:
        return same
    place = np.searchsorted(fresh, first) - 1  # of the fresh row before each run of repeats
    known = (place >= AROUND) & (place + AROUND < fresh.size)
    first, place = first[known], place[known]
    held = np.zeros(first.size, np.bool_)
    seen = [each for each in moving if each[1]] or moving  # a drive may repeat itself by chance
    for values, is_smooth in seen:
        held |= _held(values, fresh, place, is_smooth)
    found = np.zeros_like(same)
    for start, at in zip(first[held], place[held], strict=True):
        found[start : fresh[at + 1]] = True
    return found if np.count_nonzero(found) >= FEWEST else np.zeros_like(same)


def _held(
    values: FloatArray, fresh: NDArray[np.intp], place: NDArray[np.intp], is_smooth: bool
) -> NDArray[np.bool_]:
    """Whether a channel shows of each run of repeats that it was held, (runs,)."""
    half = values.size // 2
    count = max(quantum(values), quantum(values[:half]), quantum(values[half:]))
    step = max(count, 3.0 * noise(values), 1e-4 * float(np.ptp(values)))

    def speed(start: int, end: int) -> FloatArray:
        at = fresh[place[:, None] + np.arange(start, end + 1)]
        steps = np.diff(values[at], axis=1) / np.diff(at, axis=1)
        largest = np.argmax(np.abs(steps), axis=1)[:, None]
        np.put_along_axis(steps, largest, 0.0, axis=1)  # which may be a leap
        return np.asarray(np.abs(steps.sum(axis=1)) / (end - start - 1))

    before = speed(-AROUND, 0)
    found = np.minimum(before, speed(0, AROUND)) > STEPS * step  # on both sides
    if not is_smooth:
        return np.asarray(found)
    after, missed = speed(1, AROUND), fresh[place + 1] - fresh[place]
    leap = np.abs(values[fresh[place + 1]] - values[fresh[place]])
    most = AT_MOST * np.maximum(before, after) * missed
    return np.asarray(found | ((leap > np.maximum(LEAP * step, AT_ONCE * after)) & (leap < most)))
