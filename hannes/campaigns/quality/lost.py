"""Rows lost under a clock that was made by counting: the command leaps by several of its steps."""

from collections.abc import Iterator

import numpy as np

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.motion import is_rougher
from hannes.campaigns.quality.subject import AROUND, Subject, alone, noise, quantum

LEAP = 1.7  # steps of the command before and after, that one step of it is
ALIKE = 0.3  # relative, by which the steps before and after a leap may differ
ROUNDED = 1.5  # counts, by which steps of a command in whole counts differ
STEADY, CLEAR = 3.0, 6.0  # smallest counts, and noises, of a step of a measured motion
MOVED_ON = 2.5  # steps before and after, of a motion: two samples at least
FEW = 3  # times that both leap, or a slow motion does
WIDE, AHEAD = 20, 10.0  # samples on each side of such a leap, and counts that it goes on in them
SKIPPED = 0.01  # share of intervals that are gaps, of a clock that shows itself what is lost
LEAST = 1e-4  # of the command's range: smaller steps are no motion


def inspect(subject: Subject) -> Iterator[Finding]:
    """A leap in a command, else in a motion, that goes on evenly before and after it.

    No samples are lost unseen where the clock has gaps of its own: it was read, not counted.
    """
    gaps = float(np.mean(np.diff(subject.time) > 1.5 * subject.interval))
    every = list(_commanded(subject)) or list(_moved(subject))
    yield from (each for each in every if each.kind != "lost" or gaps < SKIPPED)


def _moved(subject: Subject) -> Iterator[Finding]:
    """A leap in what a sensor reads of a smooth motion."""
    for name in subject.recording.names:
        if not subject.is_motion(name):
            continue
        values = subject.recording[name]
        steps, count = np.diff(values), quantum(values)
        least = max(STEADY * count, CLEAR * noise(values), LEAST * float(np.ptp(values)))
        places = _leaps(steps, least, count) or _slow_leaps(steps, least, count)
        even = [k for k in places if np.diff(subject.time[k : k + 2])[0] < 1.5 * subject.interval]
        even = [k for k in even if abs(steps[k]) > MOVED_ON * abs(_usual(steps, k))]
        together = _together(subject, name, steps, count)
        if together:
            yield _finding(subject, name, steps, together)
        elif even and subject.of(name).follows in subject.recording:
            yield _jumped(subject, name, steps, even[0])
        elif even:
            yield _finding(subject, name, steps, even, " (or the encoder lost count)")
        if together or even:
            return


def _jumped(subject: Subject, name: str, steps: np.ndarray, place: int) -> Finding:
    size = float(steps[place] - _usual(steps, place))
    return fault(
        "jump",
        name,
        f"leaps by {subject.with_unit(size, name)} at {subject.time[place + 1]:.4g} s, and its "
        "command does not: the encoder lost count; leave out what follows (time.cut)",
        time=float(subject.time[place + 1]),
        size=size,
        mend=mends.rest(subject, place + 1),
    )


def _together(subject: Subject, name: str, steps: np.ndarray, count: float) -> list[int]:
    """Places where a motion leaps and its command with it: no machine follows at once."""
    command = subject.of(name).follows
    if command not in subject.recording or steps.size < 4 * AROUND:
        return []
    asked = np.diff(subject.recording[command])
    least = max(2.0 * STEADY * count, CLEAR * noise(subject.recording[name]))
    both = alone(steps, least) & alone(asked, LEAST * float(np.ptp(subject.recording[command])))
    places = np.flatnonzero(both & (np.diff(subject.time) < 1.5 * subject.interval))
    return [int(k) for k in places] if places.size <= FEW else []


def _commanded(subject: Subject) -> Iterator[Finding]:
    """A leap in a command."""
    for name in subject.commands & set(subject.recording.names):
        following = [n for n, each in subject.expected.items() if each.follows == name]
        if any(is_rougher(subject, name, n) for n in following if n in subject.recording):
            continue  # it is no command
        steps = np.diff(subject.recording[name])
        intervals = np.diff(subject.time)
        values = subject.recording[name]
        places = _leaps(steps, LEAST * float(np.ptp(values)), quantum(values))
        even = [k for k in places if intervals[k] < 1.5 * subject.interval]
        if not even:
            continue
        yield _finding(subject, name, steps, even)
        return


def _finding(
    subject: Subject, name: str, steps: np.ndarray, places: list[int], other: str = ""
) -> Finding:  # fmt: skip
    """Samples lost; `other` is what else it may be."""
    first = int(places[0])
    known = [(steps[k], _usual(steps, k)) for k in places]
    count = sum(max(round(step / usual) - 1, 1) for step, usual in known if usual) or len(places)
    return fault(
        "lost",
        "time",
        f"some {count} samples lost at {subject.time[first]:.4g} s{other} though the times run on "
        f"evenly: {name} leaps there; take true times, or leave out what follows (time.cut)",
        time=float(subject.time[first]),
        size=float(count),
        mend=mends.rest(subject, first + 1),
    )


def _slow_leaps(steps: np.ndarray, least: float, count: float) -> list[int]:
    """Places where a motion of a count or so a sample leaps, and goes on as fast as before."""
    found = []
    for k in np.flatnonzero(alone(steps, 2.0 * least)):
        before, after = steps[max(k - WIDE, 0) : k], steps[k + 1 : k + 1 + WIDE]
        if min(before.size, after.size) < WIDE:
            continue
        speeds = float(before.mean()), float(after.mean())
        usual = sum(speeds) / 2.0
        even = abs(speeds[0] - speeds[1]) < 2.0 * ALIKE * abs(usual)
        goes = abs(usual) * WIDE > AHEAD * count and steps[k] / usual > 2.0 * MOVED_ON
        if even and goes and max(np.abs(before).max(), np.abs(after).max()) < abs(steps[k]) / 3.0:
            found.append(int(k))
    return found if len(found) <= FEW else []


def _usual(steps: np.ndarray, place: int) -> float:
    near = np.r_[steps[max(place - WIDE, 0) : place], steps[place + 1 :][:WIDE]]
    close = np.r_[steps[place - AROUND : place], steps[place + 1 :][:AROUND]]
    usual = float(np.median(close))
    slow = np.abs(usual) < 2.0 * np.median(np.abs(np.diff(near)))
    return float(near.mean()) if slow else usual


def _leaps(steps: np.ndarray, least: float, count: float) -> list[int]:
    """Places where a step is a multiple of those around, which are alike.

    count: smallest step of the command, by which rounding alone makes steps differ.
    """
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
        alike = np.abs(around - usual).max() < max(ALIKE * abs(usual), ROUNDED * count)
        rounded = abs(steps[k] - usual) < ROUNDED * count
        if alike and abs(usual) > least and steps[k] / usual > LEAP and not rounded:
            found.append(int(k))
    return found if len(found) <= max(3, steps.size // 200) else []
