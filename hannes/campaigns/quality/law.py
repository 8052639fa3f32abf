"""What ties a drive to its motion throughout a run, and where that breaks.

Two laws are looked for, both linear with unknown coefficients: that of the winding (its current
follows from duty and speed) and that of the controller (its output follows from the error, the
integral of that, and both speeds). Where a law explains nearly all of a drive on either side of a
place, and its gain or its zero is another from there on, something changed in the log that no
machine does: the range of a probe was switched, or the encoder slipped on its shaft. Where the law
asks for a drive and there is none, the drive was off. Values are means over parts of the run.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.subject import Subject

FloatArray = NDArray[np.float64]

PARTS, FEWEST = 200, 60  # parts of a run
LEAST_SIZE = 3  # samples of each
SMOOTHED = 0.012  # s, over which a speed is taken, at least five samples
HOLDS = 0.3  # of the drive, that a law leaves whose sign counts
MOST = 5000  # samples by which a law is found


@dataclass(frozen=True)
class Relation:
    """A drive and what it follows from, as means over parts of a run.

    drive: (k,), `of` the channel of that name; columns: (k, p), the first of which is what a slip
    of the motion adds to; motion: (k,); slips: whether that column is the motion's error, else its
    speed; time: (k,) [s]; places: (k,) first sample of each part.
    """

    name: str
    of: str
    drive: FloatArray
    columns: FloatArray
    motion: FloatArray
    slips: bool
    time: FloatArray
    places: NDArray[np.intp]


def laws(subject: Subject) -> Iterator[Relation]:
    """Laws of the winding and of the controller, as far as their channels were recorded."""
    recording = subject.recording
    for name, moved in drives_of(subject):
        motion = recording[moved]
        speed = np.gradient(motion, subject.time)  # parts take its mean
        if name == "current" and "duty" in recording:
            voltage = recording["duty"] * (recording["supply"] if "supply" in recording else 1.0)
            yield _relation(subject, "winding", name, [speed, voltage], motion, False)
        asked = subject.asked_of(moved)
        if asked is not None and np.ptp(asked) > 0.0:
            error = asked - motion
            total = np.cumsum(error * np.gradient(subject.time))
            columns = [error, total, speed, np.gradient(asked, subject.time)]
            yield _relation(subject, "controller", name, columns, motion, True)


def drives_of(subject: Subject) -> Iterator[tuple[str, str]]:
    """Recorded drives that change, and the recorded motion of each."""
    recording = subject.recording
    for name, expected in subject.expected.items():
        moved = expected.drives
        if name in recording and moved in recording and np.ptp(recording[name]) > 0.0:
            yield name, moved


def answer(
    subject: Subject, name: str, on: NDArray[np.bool_]
) -> tuple[FloatArray, float]:  # fmt: skip
    """What the controller's law asks of a drive, (n,), and the RMS that it leaves where it is on.

    It is the law without its integral, which goes astray while the drive is off. What is left is
    infinite where there is too little to go by.
    """
    moved = subject.of(name).drives
    asked = subject.asked_of(moved) if moved in subject.recording else None
    few = np.flatnonzero(on)
    if asked is None or few.size < FEWEST:
        return np.zeros(on.size), float("inf")
    motion, drive = subject.recording[moved], subject.recording[name]
    parts = [asked - motion, speed_of(subject, motion), speed_of(subject, asked), np.ones(on.size)]
    columns = np.column_stack(parts)
    few = few[:: max(few.size // MOST, 1)]
    found, *_ = np.linalg.lstsq(columns[few], drive[few], rcond=None)
    left = float(np.sqrt(np.mean((drive[few] - columns[few] @ found) ** 2)))
    return columns @ found, left


def speed_of(subject: Subject, values: FloatArray) -> FloatArray:
    """Change per time, over some samples."""
    from scipy.signal import savgol_filter

    size = min(max(5, round(SMOOTHED / subject.interval) | 1), (values.size - 1) | 1)
    if size > values.size:
        return np.gradient(values, subject.time)
    return np.asarray(savgol_filter(values, size, 1, deriv=1, delta=subject.interval))


def _relation(
    subject: Subject, name: str, of: str, columns: list[FloatArray], motion: FloatArray, slips: bool
) -> Relation:
    count = max(min(PARTS, motion.size // LEAST_SIZE), 1)
    size = motion.size // count
    kept = slice(0, size * count)

    def parts(values: FloatArray) -> FloatArray:
        return values[kept].reshape(count, size).mean(axis=1)

    drive = parts(subject.recording[of])
    table = np.column_stack([*(parts(each) for each in columns), np.ones(count)])
    places = np.arange(count) * size
    return Relation(name, of, drive, table, parts(motion), slips, subject.time[places], places)


def pushes_away(law: Relation) -> bool:
    """Whether a law of the controller holds, and drives the motion away from its command."""
    if law.drive.size < FEWEST:
        return False
    columns = scaled(np.delete(law.columns, 1, axis=1))  # without the integral
    found, *_ = np.linalg.lstsq(columns, law.drive, rcond=None)
    left = float(np.std(law.drive - columns @ found))
    base, _ = np.linalg.qr(columns[:, 1:])
    without = float(np.std(law.drive - base @ (base.T @ law.drive)))
    holds = left < HOLDS * float(np.std(law.drive)) and left < 0.5 * without
    return bool(holds and found[0] < 0.0)


def zero_of(subject: Subject, moved: str) -> float | None:
    """How far a motion's zero is from its command's, by the law of the controller.

    The law has no constant where error and drive vanish together. None where no law holds.
    """
    best: tuple[float, float] | None = None
    for law in laws(subject):
        if law.slips and subject.of(law.of).drives == moved and law.drive.size >= FEWEST:
            columns = np.delete(law.columns, 1, axis=1)  # without the integral
            scale = np.abs(columns).max(axis=0)
            scale[scale == 0.0] = 1.0
            found, *_ = np.linalg.lstsq(columns / scale, law.drive, rcond=None)
            left = float(np.std(law.drive - columns / scale @ found) / np.std(law.drive))
            if left < HOLDS / 3.0 and found[0] != 0.0 and (best is None or left < best[0]):
                best = left, float(found[-1] / found[0] * scale[0])
    return best[1] if best else None


def scaled(columns: FloatArray) -> FloatArray:
    """Columns of a size of one each."""
    scale = np.abs(columns).max(axis=0)
    return columns / np.where(scale > 0.0, scale, 1.0)
