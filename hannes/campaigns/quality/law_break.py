"""The change that best explains what a law of a drive leaves: a gain, or a motion's zero."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.law import FEWEST, Relation, scaled

FloatArray = NDArray[np.float64]

EDGE = 0.06  # share of the run at either end, in which no break is seen
LEAST_FACTOR, LEAST_PART = 0.02, 0.03  # of a range, and of the drive's square to either side
FAR, FAR_LEFT = 0.7, 0.12  # logarithm of a factor, and what either part then leaves of itself
BRIEF = 0.35  # of the whole travel, over which an encoder slips at most
OWN = 0.5  # least share that a slip explains of what a law with dead time and lag leaves
BENDS = 0.02  # of a drive's range, within which a dead time turns
RAMPS, RAMP_NEAR = 40, 4  # places at which a slip may begin or end, and parts about the best


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
    columns = scaled(law.columns)
    base, _ = np.linalg.qr(columns)
    predicted = base @ (base.T @ law.drive)
    rest = law.drive - predicted
    far = _far_range(law, columns)
    if far is not None:
        return [far]
    return [_range(law, columns, base, predicted, rest), _slip(law)]


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


def _far_range(law: Relation, columns: FloatArray) -> Break | None:
    """A gain that changes by far: that of the greater part alone hides the smaller one's law."""
    count = law.drive.size
    columns = np.delete(columns, 1, axis=1) if law.slips else columns  # no integral
    best: tuple[float, int, float] | None = None
    for place in range(count // 5, count - count // 5):
        parts = law.drive[:place], law.drive[place + 1 :]  # one part has both
        found, *_ = np.linalg.lstsq(columns[:place], parts[0], rcond=None)
        before, after = columns[:place] @ found, columns[place + 1 :] @ found
        factor = float(after @ parts[1]) / max(float(after @ after), 1e-300)
        sizes = [max(float(np.std(each)), 1e-300) for each in parts]
        left = max(
            np.std(parts[0] - before) / sizes[0], np.std(parts[1] - factor * after) / sizes[1]
        )
        if factor > 0.0 and (best is None or left < best[0]):
            best = float(left), place, factor
    if best is None or best[0] > FAR_LEFT or abs(np.log(best[2])) < FAR:
        return None
    return Break("range", best[1], count - 1, best[2], 1.0, best[0], 1.0)


def _slip(law: Relation) -> Break:
    """The motion that is read falls behind that of the shaft for a while.

    Its error, or its speed, then no longer follows from the drive and the rest as it did.
    """
    read = law.columns[:, 0]
    columns = scaled(np.column_stack((law.drive, law.columns[:, 1:])))
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
    for _ in range(2):  # on a grid by travel, then about its best
        (first, last), added = _best_ramp(law, base, rest, pairs)
        near = np.arange(-RAMP_NEAR, RAMP_NEAR + 1)
        about = [(first + i, last + j) for i in near for j in near]
        pairs = np.array([(a, b) for a, b in about if 0 <= a < b < count])
    table = np.column_stack((columns, added))
    found, *_ = np.linalg.lstsq(table, read, rcond=None)
    if (found[-1] > 0.0) != law.slips:  # what slips is read to move less, so its error grows
        return NOTHING
    if _share_beside(read, np.column_stack((columns, *_of_the_drive(law))), added) < OWN:
        return NOTHING
    return _break("slip", first, last, float(found[-1]), read, rest, read - table @ found)


def _of_the_drive(law: Relation) -> list[FloatArray]:
    """What a drive adds that a law does not have: a bridge's dead time, and a sensor's lag."""
    least = BENDS * float(np.ptp(law.drive))
    return [law.drive / np.hypot(law.drive, least), np.gradient(law.drive, law.time)]


def _share_beside(values: FloatArray, columns: FloatArray, added: FloatArray) -> float:
    """Share that one more column explains of what others leave of the values."""
    base, _ = np.linalg.qr(columns)
    rest = values - base @ (base.T @ values)
    return float(_gains(base, rest, added[:, None])[0])


def _best_ramp(
    law: Relation, base: FloatArray, rest: FloatArray, pairs: NDArray[np.intp]
) -> tuple[tuple[int, int], FloatArray]:
    """First and last part of the slip that explains most of a residual, and its column (k,)."""
    read = law.columns[:, 0]
    place = np.arange(read.size)[:, None]
    if law.slips:
        clamped = np.clip(place, pairs[:, 0], pairs[:, 1])
        ways = (law.motion, law.motion + read)  # of what is read, or asked where it is lost whole
        added = np.hstack([each[clamped] - each[pairs[:, 0]] for each in ways])
        pairs = np.vstack((pairs, pairs))
    else:
        added = (read - rest)[:, None] * ((place >= pairs[:, 0]) & (place < pairs[:, 1]))
    best = int(np.argmax(_gains(base, rest, added)))
    return (int(pairs[best, 0]), int(pairs[best, 1])), added[:, best]


def _break(
    kind: str, place: int, end: int, size: float, values: FloatArray, rest: FloatArray,
    left: FloatArray,
) -> Break:  # fmt: skip
    whole = float(np.std(values))
    before, after = (float(np.sqrt(np.mean(each**2))) / max(whole, 1e-300) for each in (rest, left))
    share = 1.0 - (after / max(before, 1e-300)) ** 2
    return Break(kind, place, end, size, share, after, before)
