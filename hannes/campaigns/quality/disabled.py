"""A drive that was switched off within a run: no drive while the command goes on."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.held import held_frames
from hannes.campaigns.quality.law import answer, drives_of
from hannes.campaigns.quality.motion import UNLIKE, found_lag
from hannes.campaigns.quality.subject import Subject, noise, quantum, true_runs
from hannes.core.recording.median_of_few import median_of_three

FloatArray = NDArray[np.float64]

NOTHING = 0.03  # of the largest drive: none, within noise
ACTIVE = 0.1  # of the largest drive, from which it was enabled
SHORTEST, BRIEF = 3, 6  # samples without any drive, and without a law that asks for one
# Of its range, that the command moves meanwhile: at least, and by itself enough.
LEAST, ASKED = 0.01, 0.1
FURTHER = 2.0  # times the largest error before, at the end of a stretch in which it moves less
# Residuals of the controller's law, share of the largest drive, and steps, that are missing.
CLEARLY, WANTED, COUNTS = 6.0, 0.1, 3.0
UNUSUAL = 2.0  # times what the law leaves before over any stretch as long
# Lags [s] and their number, with which a motion followed before, and how near, of its range.
LONGEST, LAGS, NEAR = 0.3, 31, 0.12
USUAL = 0.1  # s, lag of a motion of which the plant says nothing
WHOLE = 2.0  # times as long as its samples alone, that a stretch may last
TENTHS = 10  # parts of a stretch, through one of which a machine is far from its command
FEW = 3  # longest stretches of equal readings that are looked at
LEAST_STOOD, MOST_STOOD = 14, 0.7  # equal readings of a motion, and of the recording at most
STOOD, HOLDS = 0.2, 0.1  # of the drive that its law then misses, and that it leaves elsewhere
MOSTLY = 0.7  # of the readings of a sensor that stands, that are equal
STILL = 0.3  # of the command's move, that the machine makes meanwhile


def inspect(subject: Subject) -> Iterator[Finding]:
    """Stretches without drive though the controller has cause for one."""
    recording = subject.recording
    drives = [n for n, each in subject.expected.items() if each.drives and n in recording]
    moved = next((n for n, each in subject.expected.items() if each.follows and n in recording), "")
    asked = subject.asked_of(moved) if moved else None
    if not drives or not moved or asked is None or np.ptp(asked) == 0.0:
        return
    off = np.all([_idle(recording[name]) for name in drives], axis=0)
    off &= ~held_frames(subject) | np.all([recording[name] == 0.0 for name in drives], axis=0)
    used = np.any([_used(recording[name]) for name in drives], axis=0)
    long = [each for each in true_runs(off) if used[each[0]] and each[1] - each[0] + 1 >= SHORTEST]
    long = [each for each in long if _is_whole(subject, *each)]
    long = [each for each in long if all(_averages_zero(recording[n], *each) for n in drives)]
    if not long:
        return
    lag = (subject.of(moved).lag or USUAL) / subject.interval
    follower = _Follower(recording[moved], asked, max(round(lag), 1))
    answers = [_Answer(recording[name], *answer(subject, name, ~off)) for name in drives]
    runs = [
        each
        for each in long
        if follower.is_behind(*each)
        or follower.is_away(*each)  # so it is the drive that stops, and not its sensor
        or (
            any(one.is_wanted(*each) for one in answers)
            and (follower.departs(*each) or not all(_stands(recording[n], *each) for n in drives))
        )
    ]
    if not runs or _another_run(subject, moved, asked, *runs[0]):
        return
    first = runs[0][0]
    lasting = float(sum(subject.time[b] - subject.time[a] for a, b in runs))
    yield fault(
        "disabled",
        drives[0],
        f"is zero for {lasting:.3g} s from {subject.time[first]:.4g} s on while {moved} is away "
        "from its command: the drive was switched off; leave out what follows (time.cut)",
        time=float(subject.time[first]),
        size=lasting,
        mend=mends.rest(subject, first),
    )


def _averages_zero(values: FloatArray, first: int, last: int) -> bool:
    """Whether a stretch has no mean: of a small drive its noise hides the values, not the mean."""
    part = values[first : last + 1]
    chance = 4.0 * noise(values) / np.sqrt(part.size)
    least = max(NOTHING * float(np.abs(values).max()), chance, quantum(values))
    return abs(float(np.mean(part))) <= least


def _is_whole(subject: Subject, first: int, last: int) -> bool:
    """Whether most of a stretch was logged: what a gap hides says nothing."""
    lasting = float(subject.time[last] - subject.time[first])
    return lasting < WHOLE * (last - first) * subject.interval


def stood(subject: Subject) -> Iterator[Finding]:
    """Equal readings of a motion while the controller's drive says that its error changes."""
    pairs = list(drives_of(subject))
    for moved in dict.fromkeys(moved for _, moved in pairs):
        yield from _stood(subject, [name for name, each in pairs if each == moved], moved)


def _stood(subject: Subject, drives: list[str], moved: str) -> Iterator[Finding]:
    values = subject.recording[moved]
    runs = sorted(true_runs(np.diff(values) == 0.0), key=lambda each: each[0] - each[1])
    kept = [
        each
        for each in runs[:FEW]
        if each[1] - each[0] + 2 >= LEAST_STOOD and each[1] - each[0] <= MOST_STOOD * values.size
    ]
    on = np.ones(values.size, np.bool_)
    for first, last in kept:
        on[first : last + 2] = False
    for name in drives if kept else ():
        drive = subject.recording[name]
        predicted, left = answer(subject, name, on)
        if not left < HOLDS * float(np.std(drive)):
            continue
        least = max(CLEARLY * left, STOOD * float(np.abs(drive).max()))
        for first, last in kept:
            late = slice((first + last) // 2, last + 2)
            if abs(float(np.mean(drive[late] - predicted[late]))) > least:
                yield _is_frozen(subject, moved, name, first, last + 1)
                return


def _is_frozen(subject: Subject, moved: str, name: str, first: int, last: int) -> Finding:
    value = subject.with_unit(float(subject.recording[moved][first]), moved)
    lasting = float(subject.time[last] - subject.time[first])
    return fault(
        "frozen",
        moved,
        f"stays at {value} for {lasting:.3g} s while {name} says that it moves: the sensor dropped "
        "out, or its encoder slips; leave out what follows (time.cut)",
        time=float(subject.time[first]),
        size=lasting,
        mend=mends.rest(subject, first),
    )


def _another_run(
    subject: Subject, moved: str, asked: FloatArray, first: int, last: int
) -> bool:  # fmt: skip
    """Whether a motion does not follow this command anyway, and did not before it was off."""
    motion = subject.recording[moved]
    lag = found_lag(subject, motion, subject.time, asked)
    if lag is not None and lag.against <= UNLIKE:
        return False
    size = float(np.ptp(asked[:first])) if first > SHORTEST else 0.0
    if size < ASKED * float(np.ptp(asked)):
        return last < len(subject.recording) - BRIEF  # it is driven again, and does not follow
    shifts = np.unique(np.linspace(0.0, LONGEST / subject.interval, LAGS).astype(int))
    apart = [
        float(np.sqrt(np.mean((asked[: first - k] - motion[k:first]) ** 2)))
        for k in shifts
        if k < first // 2
    ]
    return min(apart) > NEAR * size


def _idle(values: FloatArray) -> NDArray[np.bool_]:
    """Where a drive does nothing, but for its noise."""
    band = max(NOTHING * float(np.abs(values).max()), 4.0 * noise(values), quantum(values))
    return np.asarray(np.abs(median_of_three(values)) <= band)


def _stands(values: FloatArray, first: int, last: int) -> bool:
    """Whether a noisy channel hardly shows its noise: its sensor stands, not the drive."""
    same = np.diff(values[first : last + 1]) == 0.0
    return noise(values) > quantum(values) / 2.0 and float(np.mean(same)) > MOSTLY


def _used(values: FloatArray) -> NDArray[np.bool_]:
    """Whether the drive has been active before each sample: it was enabled."""
    return np.asarray(np.maximum.accumulate(np.abs(values)) > ACTIVE * np.abs(values).max())


class _Answer:
    """A drive beside what its controller's law asks for, and what that leaves where it is on."""

    def __init__(self, drive: FloatArray, predicted: FloatArray, left: float) -> None:
        size = WANTED * float(np.abs(drive).max())
        self._least = max(CLEARLY * left, size, COUNTS * quantum(drive))
        self._predicted = predicted
        self._sums = np.concatenate(([0.0], np.cumsum(drive - predicted)))

    def is_wanted(self, first: int, last: int) -> bool:
        """Whether the controller would drive in a stretch, by what it does while it is on."""
        missing = float(np.abs(np.mean(self._predicted[first + 1 : last + 1])))
        if not missing > self._least:
            return False
        count = last - first + 1
        before = self._sums[: first + 1]
        usual = np.abs(before[count:] - before[:-count]) / count if before.size > count else before
        return missing > UNUSUAL * float(usual.max(initial=0.0))


class _Follower:
    """A motion and its command; `lag`: samples by which it may be late."""

    def __init__(self, motion: FloatArray, asked: FloatArray, lag: int) -> None:
        self._motion, self._asked, self._size = motion, asked, float(np.ptp(asked))
        self._error = np.abs(asked - motion)
        self._largest = np.maximum.accumulate(self._error)
        self._lag = min(lag, motion.size)
        self._begins = int(np.argmax(asked != asked[0]))

    def is_away(self, first: int, last: int) -> bool:
        """Whether the machine is for a while far from its command, as it never was before."""
        if last - first + 1 < BRIEF:
            return False
        least = max(ASKED * self._size, FURTHER * float(self._largest[max(first - 1, 0)]))
        parts = np.array_split(self._beyond(first, last), TENTHS)
        return any(each.size > 1 and float(each.min()) > least for each in parts)

    def _beyond(self, first: int, last: int) -> FloatArray:
        """How far the machine is from all that was asked of it lately."""
        from scipy.ndimage import maximum_filter1d, minimum_filter1d

        part, late = slice(first, last + 1), {"origin": (self._lag - 1) // 2, "mode": "nearest"}
        low = minimum_filter1d(self._asked, self._lag, **late)[part]
        high = maximum_filter1d(self._asked, self._lag, **late)[part]
        motion = self._motion[part]
        return np.asarray(np.maximum(np.maximum(low - motion, motion - high), 0.0))

    def departs(self, first: int, last: int) -> bool:
        """Whether the machine leaves its command further than it ever did before."""
        before = float(self._largest[first - 1]) if first else 0.0
        return float(self._error[first : last + 1].max()) > FURTHER * before

    def is_behind(self, first: int, last: int) -> bool:
        """Whether the command moves on in a stretch and the machine does not.

        A machine that only begins to follow is late anyway: its drive may cross zero meanwhile.
        """
        part = slice(first, last + 1)
        if last < self._begins + self._lag:
            return False
        goes = float(np.ptp(self._asked[part]))
        if last - first + 1 < BRIEF or goes < LEAST * self._size:
            return False
        if float(np.ptp(self._motion[part])) >= STILL * goes:
            return False
        before = float(self._largest[first - 1]) if first else 0.0
        return goes > ASKED * self._size or float(self._error[last]) > FURTHER * before
