"""The recording's own clock: gaps, uneven and drifting intervals, seconds and milliseconds."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, note, warning
from hannes.campaigns.quality.subject import Subject, noise, quantum, running_median, speeds

FloatArray = NDArray[np.float64]

GAP = 1.5  # median intervals
JITTER = 0.05  # of the median interval, from which uneven times give a note
LEAST_DRIFT = 2e-3  # of the rate, from the recording's start to its end
SURE = 10.0  # standard deviations, from six degrees of freedom
LEAST_LOST = 0.15  # samples by which a drifting clock is off
PARTS = 8  # of a recording, whose rates are compared
FEWEST = 80  # samples to compare rates by
SLOWEST = 0.5  # of the plant's `block`, between two samples
MOST_SET = 3  # times that a clock is set within a run
EVEN = 0.3  # of what a gap would have missed, by which a motion that goes on may differ
AROUND = 8  # samples on each side of a gap
BEYOND = 3.0  # times the fastest plausible speed, that only a wrong clock gives
OFTEN = 0.02  # of the samples, in which a motion in a wrong unit of time is too fast
LASTS = 20  # samples in a row, for which no outlier of the position is that fast
MILLI = 1000.0


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about the times alone, and about their unit."""
    intervals = np.diff(subject.time)
    even = intervals <= GAP * subject.interval
    yield from _gaps(subject, intervals, ~even)
    yield from _uneven(subject, intervals[even])
    yield from _drift(subject, intervals, even)
    yield from _unit(subject)


def _gaps(subject: Subject, intervals: FloatArray, wide: NDArray[np.bool_]) -> Iterator[Finding]:
    missing = (k for k in np.flatnonzero(wide) if not _cut(subject, int(k)))
    places = np.array([k for k in missing if _lost(subject, int(k)) > 0], np.intp)
    if not places.size:
        return
    dropped = subject.converted.dropped
    if places.size <= MOST_SET and not dropped and all(_goes_on(subject, int(k)) for k in places):
        yield _set_forward(subject, places, intervals)
        return
    worst = int(places[np.argmax(intervals[places])])
    lost = sum(_lost(subject, int(k)) for k in places)
    yield warning(
        "gap",
        "time",
        f"{places.size} gap{'s' if places.size > 1 else ''} with some {lost} samples lost, the "
        f"longest {1e3 * intervals[worst]:.4g} ms at {subject.time[worst]:.4g} s: nothing is "
        "filled in; check the logger if there are many",
        time=float(subject.time[places[0]]),
        size=float(intervals[worst]),
    )


def _goes_on(subject: Subject, place: int) -> bool:
    """Whether a motion goes on over a wide interval as from one sample to the next."""
    if not AROUND <= place < subject.time.size - AROUND - 1:
        return False
    for name in subject.recording.names:
        if not subject.is_motion(name):
            continue
        values = subject.recording[name]
        steps = np.diff(values[place - AROUND : place + AROUND + 2])
        before, after = (float(np.median(each)) for each in (steps[:AROUND], steps[AROUND + 1 :]))
        usual, step = 0.5 * (before + after), float(steps[AROUND])
        if abs(before - after) > EVEN * abs(usual):
            continue  # it starts or stops there
        least = max(2.0 * quantum(values), 4.0 * noise(values))
        missed = abs(usual) * _lost(subject, place)
        if missed > least and abs(step - usual) < EVEN * missed:
            return True
    return False


def _set_forward(
    subject: Subject, places: NDArray[np.intp], intervals: FloatArray
) -> Finding:  # fmt: skip
    first, rate = int(places[0]), 1.0 / subject.interval
    by = float(np.sum(intervals[places]) - places.size * subject.interval)
    mend = mends.rate(subject, rate)
    return fault(
        "clock",
        "time",
        f"the clock was set forward by {by:.4g} s at {subject.time[first]:.4g} s: the motion goes "
        f"on without a leap, so no samples are missing; convert with {mend[0]}",
        time=float(subject.time[first]),
        size=by,
        mend=mend,
    )


def _cut(subject: Subject, place: int) -> bool:
    """Whether a wide interval is one that the mapping cut."""
    before, after = subject.time[place], subject.time[place + 1]
    return any(before <= end and start <= after for start, end in subject.converted.cuts)


def _lost(subject: Subject, place: int) -> int:
    """Samples lost in one wide interval: by how much the times around it are set apart for good.

    A stamp that is only late is followed by a short interval; times return to where they were.
    """
    time, interval = subject.time, subject.interval
    before = np.arange(max(place - AROUND, 0), place + 1)
    after = np.arange(place + 1, min(place + 2 + AROUND, time.size))
    apart = np.median(time[after] - interval * after) - np.median(time[before] - interval * before)
    return max(round(float(apart) / interval), 0)


def _uneven(subject: Subject, intervals: FloatArray) -> Iterator[Finding]:
    spread = float(np.std(intervals))
    if spread > JITTER * subject.interval:
        yield note(
            "uneven",
            "time",
            f"intervals scatter by {1e3 * spread:.3g} ms about {1e3 * subject.interval:.4g} ms: "
            "times are used as they are; convert with time.resample for an even clock",
            size=spread,
        )


def _drift(subject: Subject, intervals: FloatArray, even: NDArray[np.bool_]) -> Iterator[Finding]:
    """Time against sample count: a trend in the mean interval of parts of the recording."""
    if np.count_nonzero(even) < FEWEST:
        return
    counts = np.array([part.sum() for part in np.array_split(even, PARTS)])
    if counts.min() == 0:
        return
    sums = np.array([part.sum() for part in np.array_split(intervals * even, PARTS)])
    means = sums / counts
    place = np.linspace(-0.5, 0.5, PARTS) * (PARTS - 1) / PARTS
    change = float(place @ means / (place @ place)) / float(means.mean())
    rest = means / means.mean() - 1.0 - change * place
    deviation = float(np.sqrt(rest @ rest / (PARTS - 2) / (place @ place)))
    lost = abs(change) * intervals.size / 8.0  # samples off a steady clock, at worst
    rate = intervals.size / float(subject.time[-1] - subject.time[0])
    if abs(change) > max(LEAST_DRIFT, SURE * deviation) and lost > LEAST_LOST:
        yield warning(
            "drift",
            "time",
            f"the clock drifts: intervals change by {100 * change:+.2g} % from start to end "
            f"against the count of samples, {lost * subject.interval:.2g} s in all: take times "
            f'from a steady clock, or convert with time.sampling = "{rate:.6g} Hz", the mean',
            size=change,
            mend=mends.rate(subject, rate),
        )


def _unit(subject: Subject) -> Iterator[Finding]:
    """Milliseconds read as seconds, or the reverse, by the limits of the plant."""
    span = float(subject.time[-1] - subject.time[0])
    if subject.block and subject.interval > SLOWEST * subject.block:
        yield fault(
            "unit",
            "time",
            f"samples lie {subject.interval:.4g} s apart, too far to see the plant move: "
            'milliseconds taken for seconds? convert with time.unit = "ms"',
            size=MILLI,
            mend=('time.unit = "ms"',),
        )
    for name, each in subject.expected.items():
        if not each.rate or name not in subject.recording:
            continue
        size = running_median(np.abs(speeds(subject.time, subject.recording[name])))
        fastest = float(size.max())
        if _too_fast(size > BEYOND * each.rate) and _plausible(subject, name):
            yield fault(
                "unit",
                "time",
                f"{name} would move at {fastest:.3g} {subject.recording.units[name]}/s over "
                f"{span:.3g} s in all: seconds taken for milliseconds? convert with times a "
                'thousand times as long: time.unit = "s", or "ks" where that is "s"',
                size=1.0 / MILLI,
                mend=('time.unit = "ks"',),
            )


def _too_fast(beyond: NDArray[np.bool_]) -> bool:
    """Whether speeds are too fast often, or for long beside a long rest; outliers are neither."""
    ends = np.flatnonzero(np.diff(beyond, prepend=False, append=False))
    longest = int(np.max(ends[1::2] - ends[::2], initial=0))
    return float(np.mean(beyond)) > OFTEN or longest > LASTS


def _plausible(subject: Subject, name: str) -> bool:
    """Whether the channel itself is of a plausible size, so that the time is to blame."""
    return float(np.abs(subject.recording[name]).max()) <= subject.of(name).peak[1]
