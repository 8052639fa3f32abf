"""Rows lost under a clock that was made by counting: the command leaps by several of its steps."""

from collections.abc import Iterator

import numpy as np

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.motion import is_rougher
from hannes.campaigns.quality.subject import Subject

LEAP = 1.7  # steps of the command before and after, that one step of it is
ALIKE = 0.3  # relative, by which the steps before and after a leap may differ
AROUND = 3  # steps on each side
LEAST = 1e-4  # of the command's range: smaller steps are no motion


def inspect(subject: Subject) -> Iterator[Finding]:
    """A leap in a command that goes on evenly before and after it."""
    for name in subject.commands & set(subject.recording.names):
        following = [n for n, each in subject.expected.items() if each.follows == name]
        if any(is_rougher(subject, name, n) for n in following if n in subject.recording):
            continue  # it is no command
        steps = np.diff(subject.recording[name])
        intervals = np.diff(subject.time)
        places = _leaps(steps, LEAST * float(np.ptp(subject.recording[name])))
        even = [k for k in places if intervals[k] < 1.5 * subject.interval]
        if not even:
            continue
        first = int(even[0])
        count = sum(round(steps[k] / _usual(steps, k)) - 1 for k in even)
        rest = mends.cut(subject, [(first + 1, len(subject.recording) - 1)])
        yield fault(
            "lost",
            "time",
            f"some {count} samples lost at {subject.time[first]:.4g} s though the times run on "
            f"evenly: {name} leaps there; take true times, or leave out what follows (time.cut)",
            time=float(subject.time[first]),
            size=float(count),
            mend=rest if first > 0.05 * steps.size else mends.NO_FILE,
        )
        return


def _usual(steps: np.ndarray, place: int) -> float:
    return float(np.median(np.r_[steps[place - AROUND : place], steps[place + 1 :][:AROUND]]))


def _leaps(steps: np.ndarray, least: float) -> list[int]:
    """Places where a step is a multiple of those around, which are alike."""
    if steps.size < 2 * AROUND + 2:
        return []
    places = np.arange(AROUND, steps.size - AROUND)
    size = np.abs(steps)
    near = np.maximum(size[places - 1], size[places + 1])
    places = places[(size[places] > 2.0 * least) & (size[places] > 1.5 * near) & (near > least)]
    if places.size > max(100, steps.size // 50):
        return []
    found = []
    for k in places:
        around = np.r_[steps[k - AROUND : k], steps[k + 1 : k + 1 + AROUND]]
        usual = float(np.median(around))
        alike = np.abs(around - usual).max() < ALIKE * abs(usual)
        if alike and abs(usual) > least and steps[k] / usual > LEAP:
            found.append(int(k))
    return found if len(found) <= max(3, steps.size // 200) else []
