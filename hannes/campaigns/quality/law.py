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
EDGE = 0.06  # share of the run at either end, in which no break is seen
HOLDS = 0.3  # of the drive, that a law leaves whose sign counts
LEAST_FACTOR, LEAST_PART = 0.02, 0.03  # of a range, and of the drive's square to either side
MOST = 5000  # samples by which a law is found
BRIEF = 0.35  # of the whole travel, over which an encoder slips at most
RAMPS = 40  # places at which a slip may begin or end


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


@dataclass(frozen=True)
class Break:
    """The change that explains most of what a law leaves.

    kind: "range" or "slip"; place: the part at which it begins; size: factor of a range, else how
    far the motion slipped; share: of the law's squared residual that it explains; left: residual
    over the drive's RMS with it; before: the same without.
    """

    kind: str
    place: int
    end: int
    size: float
    share: float
    left: float
    before: float


NOTHING = Break("range", 0, 0, 1.0, 0.0, 1.0, 1.0)


def breaks_of(law: Relation) -> list[Break]:
    """The best change of gain, and the best slip; none where there are too few parts."""
    if law.drive.size < FEWEST:
        return []
    columns = _scaled(law.columns)
    base, _ = np.linalg.qr(columns)
    predicted = base @ (base.T @ law.drive)
    rest = law.drive - predicted
    return [_range(law, columns, base, predicted, rest), _slip(law)]


def pushes_away(law: Relation) -> bool:
    """Whether a law of the controller holds, and drives the motion away from its command."""
    if law.drive.size < FEWEST:
        return False
    columns = _scaled(np.delete(law.columns, 1, axis=1))  # without the integral
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


def _gains(base: FloatArray, rest: FloatArray, added: FloatArray) -> FloatArray:
    """Share of the squared residual that each added column (k, m) explains, (m,)."""
    free = added - base @ (base.T @ added)
    squares = np.sum(free**2, axis=0)
    least = 1e-9 * np.sum(added**2, axis=0) + 1e-300
    products = np.where(squares > least, (free.T @ rest) ** 2 / np.maximum(squares, least), 0.0)
    return np.asarray(products / max(float(rest @ rest), 1e-300))


def _range(
    law: Relation, columns: FloatArray, base: FloatArray, predicted: FloatArray, rest: FloatArray
) -> Break:
    """The gain of the drive's own probe changes."""
    count = law.drive.size
    edge = round(EDGE * count)
    at = np.arange(edge, count - edge)
    after = np.arange(count)[:, None] >= at
    place = int(at[np.argmax(_gains(base, rest, after * predicted[:, None]))])
    later, factor = np.arange(count) >= place, 1.0
    for _ in range(4):
        table = np.column_stack((columns, later * predicted))
        found, *_ = np.linalg.lstsq(table, law.drive, rcond=None)
        predicted = columns @ found[:-1]
        factor = 1.0 + float(found[-1])
        left = law.drive - table @ found
    shares = [float(np.sum(predicted[each] ** 2)) for each in (~later, later)]
    if factor < LEAST_FACTOR or min(shares) < LEAST_PART * sum(shares):
        return NOTHING
    return _break("range", place, count - 1, factor, law.drive, rest, left)


def _slip(law: Relation) -> Break:
    """The motion that is read falls behind that of the shaft for a while.

    Its error, or its speed, then no longer follows from the drive and the rest as it did.
    """
    read = law.columns[:, 0]
    columns = _scaled(np.column_stack((law.drive, law.columns[:, 1:])))
    base, _ = np.linalg.qr(columns)
    rest = read - base @ (base.T @ read)
    count = law.drive.size
    travel = np.cumsum(np.abs(np.diff(law.motion, prepend=law.motion[0])))
    marks = np.linspace(EDGE, 1.0 - EDGE, RAMPS) * travel[-1]
    ends = np.unique(np.searchsorted(travel, marks))
    pairs = np.array(
        [(a, b) for a in ends for b in ends if a < b and travel[b] - travel[a] < BRIEF * travel[-1]]
    )
    if not pairs.size:
        return NOTHING
    place = np.arange(count)[:, None]
    if law.slips:
        clamped = np.clip(place, pairs[:, 0], pairs[:, 1])
        ways = (law.motion, law.motion + read)  # of what is read, or asked where it is lost whole
        added = np.hstack([each[clamped] - each[pairs[:, 0]] for each in ways])
        pairs = np.vstack((pairs, pairs))
    else:
        added = (read - rest)[:, None] * ((place >= pairs[:, 0]) & (place < pairs[:, 1]))
    best = int(np.argmax(_gains(base, rest, added)))
    table = np.column_stack((columns, added[:, best]))
    found, *_ = np.linalg.lstsq(table, read, rcond=None)
    if (found[-1] > 0.0) != law.slips:  # what slips is read to move less, so its error grows
        return NOTHING
    first, last = (int(each) for each in pairs[best])
    return _break("slip", first, last, float(found[-1]), read, rest, read - table @ found)


def _scaled(columns: FloatArray) -> FloatArray:
    """Columns of a size of one each."""
    scale = np.abs(columns).max(axis=0)
    return columns / np.where(scale > 0.0, scale, 1.0)


def _break(
    kind: str, place: int, end: int, size: float, values: FloatArray, rest: FloatArray,
    left: FloatArray,
) -> Break:  # fmt: skip
    whole = float(np.std(values))
    before, after = (float(np.sqrt(np.mean(each**2))) / max(whole, 1e-300) for each in (rest, left))
    share = 1.0 - (after / max(before, 1e-300)) ** 2
    return Break(kind, place, end, size, share, after, before)
