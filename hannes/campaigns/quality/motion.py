"""Measured motion against its command: reversed signs, wrong factors, late starts."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.subject import Subject, running_median, speeds, sustained
from hannes.core.errors import BadInput
from hannes.core.recording.time_lag import Lag, best_lag, lag_behind, time_apart

FloatArray = NDArray[np.float64]

SEARCH = 0.45  # of the recording, the widest search for a lag
PLAUSIBLE = (0.25, 4.0)  # gain of a motion over its command, a blocked one included
NEAR = 1.4  # factor within which a gain counts as that of a known mistake
SURE = 0.9  # correlation that makes a small gain more than a blocked motion
BEFORE = 5e-3  # s, by which a motion cannot run ahead of its command
IN_MOTION = 0.15  # of the fastest sustained speed, at the first sample
APART = 0.1  # of its range, that a command begins away from what follows it
FAST = 0.3  # of the fastest sustained speed: surely moving
UNLIKE = 0.45  # of the squared speed while the command does not move: no motion of this command
FOLLOWS = 0.3  # correlation of velocities, below which nothing follows
GROSS = 3.0  # times the longest plausible lag
AGAINST = 0.1  # of its rms, mean push of a drive against the motion


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about pairs of channels of which one moves the other."""
    for name, expected in subject.expected.items():
        if name not in subject.recording or np.ptp(subject.recording[name]) == 0.0:
            continue
        if expected.follows:
            yield from _started(subject, name)
        if expected.follows in subject.recording:
            yield from _follows(subject, name, expected.follows)
        if expected.drives in subject.recording:
            yield from _drives(subject, name, expected.drives)


def _started(subject: Subject, name: str) -> Iterator[Finding]:
    """A recording that begins after the command: the simulation would begin at rest."""
    speed = running_median(speeds(subject.time, subject.recording[name]))
    fastest = float(np.abs(speed).max())
    if fastest > 0.0 and abs(speed[0]) > IN_MOTION * fastest:
        yield warning(
            "late-start",
            name,
            f"already moves at {speed[0]:.3g} {subject.recording.units[name]}/s in the first "
            "sample: the recording begins after its command; start the logger earlier, or align "
            "it with the experiment when converting",
            time=float(subject.time[0]),
            size=float(speed[0]),
        )


def _follows(subject: Subject, name: str, command: str) -> Iterator[Finding]:
    motion, asked = subject.recording[name], subject.recording[command]
    if np.ptp(asked) == 0.0:
        return
    lag = found_lag(subject, motion, subject.time, asked)
    if lag is None:
        if found_lag(subject, -motion, subject.time, asked) is not None:
            yield fault(
                "sign", name, f"runs against {command}: convert one with reversed = true", size=-1.0
            )
            return
        yield from unlike(subject, name, command, subject.time, asked)
        return
    if lag.against > UNLIKE:
        yield _other_run(name, command, lag.against)
        return
    yield from _gain(subject, name, command, lag)
    yield from timed(subject, name, command, pace(subject.time, asked), lag)
    apart = float(motion[0] - asked[0])
    if abs(apart) > APART * np.ptp(asked) and PLAUSIBLE[0] < lag.gain < PLAUSIBLE[1]:
        yield warning(
            "late-start",
            name,
            f"starts {subject.with_unit(apart, name)} away from {command}: the recording begins "
            "after its command, or its zero is shifted (offset, when converting)",
            time=float(subject.time[0]),
            size=apart,
        )


def unlike(
    subject: Subject, name: str, command: str, times: FloatArray, values: FloatArray
) -> Iterator[Finding]:
    """Findings where no lag within a plausible range was found: looked for at any lag."""
    long = float(subject.time[-1] - subject.time[0]) + float(times[-1] - times[0])
    if time_apart(subject.time, times) > long:
        text = f"begins at {subject.time[0]:.10g} s, {command} ends at {times[-1]:.4g} s"
        yield fault("clock", "time", f"{text}: convert with time.from_zero or time.offset")
        return
    try:
        lag = best_lag(subject.time, subject.recording[name], times, values)
    except BadInput:  # too short, or one stands still
        return
    if lag.correlation < FOLLOWS or lag.against > UNLIKE:
        yield _other_run(name, command, lag.against)
        return
    yield from timed(subject, name, command, pace(times, values), lag)


def _other_run(name: str, command: str, share: float) -> Finding:
    """A motion that is not of this command."""
    text = f"does not follow {command} at any lag ({100.0 * share:.0f} % of it while that stands "
    text += "or turns back): a wrong column, another run, or another experiment; name the right one"
    return fault("unlike", name, text, size=share)


def found_lag(
    subject: Subject, motion: FloatArray, times: FloatArray, command: FloatArray
) -> Lag | None:
    """Lag of the motion behind its command, None where it does not follow or no lag is best."""
    within = SEARCH * float(subject.time[-1] - subject.time[0])
    try:
        return lag_behind(subject.time, motion, times, command, within)
    except BadInput:
        return None


def _gain(subject: Subject, name: str, command: str, lag: Lag) -> Iterator[Finding]:
    low, high = PLAUSIBLE
    if low <= lag.gain <= high or (lag.gain < low and lag.correlation < SURE):
        return
    moves = f"moves {lag.gain:.4g} times as far as {command}"
    for what, factor in subject.of(name).mistakes.items():
        for culprit, gain in ((name, lag.gain), (command, 1.0 / lag.gain)):
            if max(gain / factor, factor / gain) < NEAR:
                text = f"{moves}: {what} ({factor:.4g}) in {culprit}? convert with its unit or side"
                yield fault("unit", name, text, size=lag.gain)
                return
    yield fault("unit", name, f"{moves}: check unit and scale of both", size=lag.gain)


def pace(times: FloatArray, values: FloatArray) -> float:
    """Time of a command through its whole range, at its mean speed in motion [s]."""
    travel = np.abs(np.diff(values))
    moving = float(np.sum(np.diff(times)[travel > 0.0]))
    return moving * float(np.ptp(values) / max(travel.sum(), 1e-300))


def timed(subject: Subject, name: str, command: str, across: float, lag: Lag) -> Iterator[Finding]:
    """Findings about a motion that follows its command too late, or precedes it.

    `across` is the command's `pace` [s]: friction holds slow motion back by an angle, not a time.
    """
    advice = "shift it with [align] when converting"
    margin = 3.0 * lag.deviation
    if lag.value < -BEFORE - margin:
        text = f"moves {1e3 * -lag.value:.4g} ms before {command}: two clocks; {advice}"
        yield fault("late-start", name, text, size=lag.value)
    longest = subject.of(name).lag
    most = max(longest, APART * across)
    if longest and lag.value > most + margin:
        text = f"moves {1e3 * lag.value:.4g} ms behind {command}, longer than the machine takes"
        found = fault if lag.value > GROSS * most + margin else warning
        yield found("late-start", name, f"{text}: {advice}", size=lag.value)


def _drives(subject: Subject, name: str, moved: str) -> Iterator[Finding]:
    """The sign of a drive: against both directions of motion it would only brake."""
    speed = running_median(speeds(subject.time, subject.recording[moved]))
    push = subject.recording[name][1:]
    fast = FAST * sustained(speed)
    forth, back = push[speed > fast], push[speed < -fast]
    level = AGAINST * float(np.sqrt(np.mean(push**2)))
    against = forth.size > 0 and forth.mean() < -level
    if against and back.size and back.mean() > level:
        text = f"pushes against {moved} both ways: convert with reversed = true"
        yield fault("sign", name, text, size=float(forth.mean()))
    elif against:
        text = f"pushes against {moved} as it moves in + direction: is its sign reversed?"
        yield warning("sign", name, text, size=float(forth.mean()))
