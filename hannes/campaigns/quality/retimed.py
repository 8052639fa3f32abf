"""Another pace than the command's, by the law of the controller.

A controller's output follows from its error. Where the command that is known is played faster or
slower than it was, the error is wrong and the law fails; with the right pace it holds again. A
motion alone shows its pace far less well, for a machine lags, and not by the same everywhere.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.law import LEAST_SIZE, PARTS, drives_of
from hannes.campaigns.quality.subject import Subject

FloatArray = NDArray[np.float64]

COARSE = np.arange(0.5, 1.2, 0.02)  # paces that are tried first
FINER = (4e-3, 8e-4, 1.6e-4)  # steps about the best of them
FASTEST = 1.25  # beyond any pace that they lead to
AROUND = 5  # steps each way
# Samples of a recording from its start that are looked at, and of those that are taken.
LONGEST, ENOUGH = 20_000, 2000
FEWEST = 150  # samples
AHEAD = 6e-3  # s, over which a command's speed is taken
SHARE, LEFT = 0.45, 0.1  # squared residual that a pace explains; what it leaves of the drive
GOOD = 0.004  # of the drive, that a law leaves which holds
LEAST = 2e-3  # of the pace
FAILS = 1.5  # times what a law leaves at its own pace, that it leaves at one which is not so


@dataclass(frozen=True)
class _Answer:
    """Samples of a controller: times [s], (n,), and what does not change with the pace."""

    time: FloatArray
    motion: FloatArray
    speed: FloatArray
    drive: FloatArray
    asked: tuple[FloatArray, FloatArray]

    def left(self, pace: float) -> float:
        """RMS that the law leaves of the drive, as a share, with the command at a pace."""
        at = self.time[0] + pace * (self.time - self.time[0])
        error = np.interp(at, *self.asked) - self.motion
        ahead, behind = (np.interp(at + each, *self.asked) for each in (AHEAD, -AHEAD))
        total = np.cumsum(error * np.gradient(self.time))
        columns = [error, total, self.speed, ahead - behind, np.ones(self.time.size)]
        count = min(PARTS, self.time.size // LEAST_SIZE)
        size = self.time.size // count
        table = np.column_stack([*columns, self.drive])[: count * size]
        parts = table.reshape(count, size, -1).mean(axis=1)
        scale = np.abs(parts).max(axis=0)
        parts /= np.where(scale > 0.0, scale, 1.0)
        found, *_ = np.linalg.lstsq(parts[:, :-1], parts[:, -1], rcond=None)
        rest = parts[:, -1] - parts[:, :-1] @ found
        return float(np.std(rest) / max(np.std(parts[:, -1]), 1e-300))


def pace_of(subject: Subject) -> float | None:
    """Pace at which the command was carried out, of the one that is known; None where it is that.

    None, too, where no drive and command were recorded, or where no law holds.
    """
    for moved, answer in _answers(subject):
        before = answer.left(1.0)
        if before < GOOD:
            continue
        pace = _best(answer)
        left = answer.left(pace)
        better = left < LEFT and left**2 < (1.0 - SHARE) * before**2
        if better and abs(pace - 1.0) > LEAST and not refuted(subject, pace, moved):
            return pace
    return None


def refuted(subject: Subject, pace: float, moved: str) -> bool:
    """Whether a law of a motion's controller holds at the command's own pace, and fails at this.

    A machine whose friction falls in a run lags less and less, and its motion looks faster. A
    weak supply bends the law of one drive alone.
    """
    return any(
        of == moved and answer.left(1.0) < min(LEFT, answer.left(pace) / FAILS)
        for of, answer in _answers(subject)
    )


def _answers(subject: Subject) -> Iterator[tuple[str, _Answer]]:
    """Motion and answer of each controller; its drive and command were recorded for long enough."""
    for name, moved in drives_of(subject):
        asked = subject.asked_at(moved)
        if asked is None or np.ptp(asked[1]) == 0.0 or subject.time.size < FEWEST:
            continue
        size = min(subject.time.size, LONGEST)
        few = slice(0, size, max(size // ENOUGH, 1))
        motion, time = subject.recording[moved][:size], subject.time[:size]
        yield (
            moved,
            _Answer(
                subject.time[few],
                motion[few],
                np.gradient(motion, time)[few],
                subject.recording[name][few],
                _within(asked, float(time[0]), float(time[-1])),
            ),
        )


def _within(
    asked: tuple[FloatArray, FloatArray], first: float, last: float
) -> tuple[FloatArray, FloatArray]:
    """A command as far as any pace that is tried leads, from `first` to `last` [s] at its own."""
    times, values = asked
    end = first + FASTEST * (last - first) + AHEAD
    low, high = np.searchsorted(times, first - AHEAD), np.searchsorted(times, end)
    part = slice(max(int(low) - 1, 0), int(high) + 1)
    return times[part], values[part]


def _best(answer: _Answer) -> float:
    pace = min(map(float, COARSE), key=answer.left)
    for step in FINER:
        near = pace + step * np.arange(-AROUND, AROUND + 1)
        pace = min(map(float, near), key=answer.left)
    return pace
