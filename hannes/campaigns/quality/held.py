"""Samples that were held: all channels at once by a logger, one channel by a slower source."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.finding import Finding, warning
from hannes.campaigns.quality.subject import Subject, noise, quantum, true_runs

FloatArray = NDArray[np.float64]

FEWEST = 3  # repeated samples that are no chance
AROUND = 6  # samples on each side by which a channel is seen to go on
STEPS = 2.0  # of a channel's steps a sample: it cannot repeat itself
REGULAR = 0.8  # share of changes that lie a whole number of periods apart
FEWEST_CHANGES = 12
SLOWER = 2  # samples between changes, at least


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about samples that repeat."""
    if all(renewal(subject, name) == 1 for name in subject.recording.names):
        yield from _frames(subject)
    for name in subject.recording.names:
        if name not in subject.commands:
            yield from _slower(subject, name)


def held_frames(subject: Subject) -> NDArray[np.bool_]:
    """Whether each sample repeats all measured channels though it should not, shape (n,).

    A machine at rest, or at its turn, repeats itself rightly: a repeat counts where the channels
    around it go on by several of their steps.
    """
    recording = subject.recording
    measured = (name for name in recording.names if name not in subject.commands)
    names = [name for name in measured if np.ptp(recording[name]) > 0.0]
    same = np.zeros(len(subject.time), np.bool_)
    if len(names) < 2:
        return same
    same[1:] = np.all([np.diff(recording[name]) == 0.0 for name in names], axis=0)
    if not same.any():
        return same
    goes_on = np.any([_goes_on(recording[name]) for name in names], axis=0)
    same &= goes_on
    return same if np.count_nonzero(same) >= FEWEST else np.zeros_like(same)


def _goes_on(values: FloatArray) -> NDArray[np.bool_]:
    """Where a channel, by its samples around, changes by several of its steps a sample."""
    step = max(quantum(values), 3.0 * noise(values), 1e-4 * float(np.ptp(values)))
    ahead = np.roll(values, -AROUND) - np.roll(values, AROUND)
    ahead[:AROUND], ahead[-AROUND:] = 0.0, 0.0
    return np.abs(ahead) / (2 * AROUND) > STEPS * step


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


def _slower(subject: Subject, name: str) -> Iterator[Finding]:
    """A channel whose values are renewed less often than the log has samples."""
    period = renewal(subject, name)
    if period < SLOWER:
        return
    step = float(period * subject.interval)
    yield warning(
        "held",
        name,
        f"is renewed every {1e3 * step:.4g} ms only and held between: convert with "
        f'time.resample = "{1.0 / step:.4g} Hz"',
        size=step,
    )
