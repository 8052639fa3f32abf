"""Samples that were held: all channels at once by a logger, one channel by a slower source."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.finding import Finding, warning
from hannes.campaigns.quality.subject import Subject, noise, quantum, true_runs

FloatArray = NDArray[np.float64]

REGULAR = 0.8  # share of changes that lie a whole number of periods apart
FEWEST_CHANGES = 12
SLOWER = 2  # samples between changes, at least


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about samples that repeat."""
    if all(renewal(subject, name) == 1 for name in subject.recording.names):
        yield from _frames(subject)
    yield from _slower(subject)


def held_frames(subject: Subject) -> NDArray[np.bool_]:
    """Whether each sample repeats all measured channels though it should not, shape (n,).

    A machine at rest, or at its turn, repeats itself rightly: a repeat counts where the channels
    around it go on by several of their steps.
    """
    return subject.held


def _frames(subject: Subject) -> Iterator[Finding]:
    """A logger that repeats whole frames while the machine goes on."""
    same = held_frames(subject)
    runs = true_runs(same)
    if not runs:
        return
    first, last = max(runs, key=lambda each: each[1] - each[0])
    longest = float(subject.time[last] - subject.time[max(first - 1, 0)])
    yield warning(
        "held",
        "time",
        f"{np.count_nonzero(same)} samples repeat all that was measured, the longest for "
        f"{1e3 * longest:.4g} ms at {subject.time[first]:.4g} s: the logger repeats frames; "
        'convert with time.repeats = "drop"',
        time=float(subject.time[runs[0][0]]),
        size=longest,
        mend=('time.repeats = "drop"',),
    )


def renewal(subject: Subject, name: str) -> int:
    """Samples between two values of a channel that is renewed less often than logged, else 1."""
    values = subject.recording[name]
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    if changes.size < FEWEST_CHANGES:
        return 1
    gaps = np.diff(changes)
    period = int(gaps.min())
    if period < SLOWER or float(np.mean(gaps % period == 0)) < REGULAR:
        return 1
    large = float(np.median(np.abs(np.diff(values[changes])))) > 2.5 * quantum(values)
    return period if large or noise(values[changes]) > 0.0 else 1


def _slower(subject: Subject) -> Iterator[Finding]:
    """Channels whose values are renewed less often than the log has samples, by their period."""
    names = [name for name in subject.recording.names if name not in subject.commands]
    periods = {name: renewal(subject, name) for name in names}
    for period in sorted({each for each in periods.values() if each >= SLOWER}):
        slow = [name for name in names if periods[name] == period]
        step = float(period * subject.interval)
        also = f" (so are {', '.join(slow[1:])})" if len(slow) > 1 else ""
        keys = tuple(f"channels.{name}.renewed = {period}" for name in slow)
        yield warning(
            "held",
            slow[0],
            f"is renewed every {1e3 * step:.4g} ms only and held between{also}: convert with "
            f'{keys[0]}, or time.resample = "{1.0 / step:.6g} Hz"',
            size=step,
            mend=keys,
        )
