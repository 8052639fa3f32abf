"""Measured motion against its command: reversed signs, wrong factors, late starts."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.subject import Subject
from hannes.campaigns.quality.zero import PLAUSIBLE, STANDS, away, begins_moving
from hannes.core.errors import BadInput
from hannes.core.recording.time_lag import Lag, best_lag, lag_behind, time_apart

FloatArray = NDArray[np.float64]

SEARCH = 0.45  # of the recording, the widest search for a lag
NEAR = 1.4  # factor within which a gain counts as that of a known mistake
SURE = 0.9  # correlation that makes a small gain more than a blocked motion
BEFORE = 5e-3  # s, by which a motion cannot run ahead of its command
HELD_BACK = 0.1  # of the time through its range, by which friction holds a motion back
DEGREES = 57.29578
FOLLOWED = 0.7  # correlation of a command that follows its motion
SMOOTHER = 3.0  # times, that a command is smoother than what a sensor reads
# Correlation, below which an implausible lag is no lag but another run; of a motion that an object
# ends early, and of a free one.
SAME_RUN, BLOCKED = (0.85, 0.95), 0.8
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
    if begins_moving(subject, name) and not _amid_the_plan(subject):
        speed = subject.speed(name)
        yield warning(
            "late-start",
            name,
            f"already moves at {speed[0]:.3g} {subject.recording.units[name]}/s in the first "
            "sample: the recording begins after its command; start the logger earlier, or align "
            "it with the experiment when converting",
            time=float(subject.time[0]),
            size=float(speed[0]),
            mend=_onto_experiment(subject),
        )


def _amid_the_plan(subject: Subject) -> bool:
    """Whether a recording begins when its experiment, which is simulated from its start, moves."""
    plan = subject.plan
    if plan is None or "reference" in subject.recording:
        return False
    moved = abs(float(np.interp(subject.time[0], plan.times, plan.values) - plan.values[0]))
    return moved > STANDS * float(np.ptp(plan.values))


def _onto_experiment(subject: Subject) -> tuple[str, ...]:
    """A recording alone is moved onto its experiment; with its command it cannot be mended."""
    alone = subject.plan is not None and "reference" not in subject.recording
    return mends.aligned("experiment", 1.0) if alone else mends.NO_FILE


def _follows(subject: Subject, name: str, command: str) -> Iterator[Finding]:
    motion, asked = subject.recording[name], subject.recording[command]
    if np.ptp(asked) == 0.0:
        return
    if np.array_equal(motion, asked):
        text = f"equals {command} in every sample, as no machine follows: one column was taken "
        text += f"twice, or logged twice; map the other one, or leave {command} out"
        yield fault("swapped", name, text, mend=mends.without(subject, command))
        return
    lag = found_lag(subject, motion, subject.time, asked)
    if lag is None or _implausible(subject, name, lag) or lag.correlation < SURE:
        against = found_lag(subject, -motion, subject.time, asked)
        better = against is not None and (lag is None or against.correlation > lag.correlation)
        if better and against is not None and not _implausible(subject, name, against):
            mend = mends.reversed_sign(subject, name)
            text = f"runs against {command}: convert with {mend[0]}"
            yield fault("sign", name, text, size=-1.0, mend=mend)
            return
    if _swapped(subject, name, command, lag or _best(subject, motion, asked)):
        why = f"moves before {command}, which is rough as a sensor is"
        yield other_way_round(subject, name, command, why)
        return
    if lag is None:
        yield from unlike(subject, name, command, subject.time, asked)
        return
    if lag.against > UNLIKE:
        yield _other_run(name, command, lag.against)
        return
    yield from _gain(subject, name, command, lag)
    yield from timed(subject, name, command, pace(subject.time, asked), lag)
    yield from away(subject, name, command, lag)


def _implausible(subject: Subject, name: str, lag: Lag) -> bool:
    """Whether a motion leads its command, or lags longer than a machine does."""
    most = max(subject.of(name).lag, BEFORE)
    return lag.value < -BEFORE - 3.0 * lag.deviation or lag.value > GROSS * most


def _best(subject: Subject, motion: FloatArray, asked: FloatArray) -> Lag | None:
    try:
        return best_lag(subject.time, motion, subject.time, asked)
    except BadInput:
        return None


def _swapped(subject: Subject, name: str, command: str, lag: Lag | None) -> bool:
    """A motion ahead of a command that is rough as a sensor is, while the motion is smooth."""
    if lag is None:
        return False
    ahead = -lag.value > 2.0 * lag.deviation and lag.correlation > FOLLOWED
    return ahead and is_rougher(subject, command, name)


def is_rougher(subject: Subject, name: str, other: str) -> bool:
    """Whether a channel is rough as a sensor is, beside one that is smooth as what is drawn."""
    rough = [_roughness(subject.recording[each]) for each in (name, other)]
    return rough[0] > SMOOTHER * rough[1]


def _roughness(values: FloatArray) -> float:
    """Scatter of second differences, over the range: small for what a computer drew."""
    second = np.abs(np.diff(values, 2))
    return float(np.median(second[second > 0.0])) / float(np.ptp(values)) if second.any() else 0.0


def other_way_round(subject: Subject, name: str, command: str, why: str) -> Finding:
    """The columns of a motion and its command taken for each other."""
    columns = subject.converted.columns
    is_of, should = (columns.get(each, each) for each in (name, command))
    mend = (f'channels.{name}.column = "{should}"', f'channels.{command}.column = "{is_of}"')
    text = f"{why}: the two columns are swapped; convert with {' and '.join(mend)}"
    return fault("swapped", name, text, mend=mend)


def unlike(
    subject: Subject, name: str, command: str, times: FloatArray, values: FloatArray
) -> Iterator[Finding]:
    """Findings where no lag within a plausible range was found: looked for at any lag."""
    long = float(subject.time[-1] - subject.time[0]) + float(times[-1] - times[0])
    if time_apart(subject.time, times) > long:
        text = f"begins at {subject.time[0]:.10g} s, {command} ends at {times[-1]:.4g} s"
        mend = ("time.from_zero = true",)
        yield fault("clock", "time", f"{text}: convert with {mend[0]}, or time.offset", mend=mend)
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
    return fault("unlike", name, text, size=share, mend=mends.NO_FILE)


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
    degrees = {"degrees taken for rad": DEGREES} if subject.recording.units[name] == "rad" else {}
    for what, factor in {**degrees, **subject.of(name).mistakes}.items():
        for culprit, gain in ((name, lag.gain), (command, 1.0 / lag.gain)):
            if max(gain / factor, factor / gain) < NEAR:
                mend = mends.of_mistake(subject, culprit, factor, what)
                text = f"{moves}: {what} ({factor:.4g}) in {culprit}? convert with {mend[0]}"
                yield fault("unit", name, text, size=lag.gain, mend=mend)
                return
    mend = mends.scaled(subject, name, lag.gain)
    text = f"{moves}: check unit and scale of both, such as {mend[0]}"
    yield fault("unit", name, text, size=lag.gain, mend=mend)


def pace(times: FloatArray, values: FloatArray) -> float:
    """Time of a command through its whole range, at its mean speed in motion [s]."""
    travel = np.abs(np.diff(values))
    moving = float(np.sum(np.diff(times)[travel > 0.0]))
    return moving * float(np.ptp(values) / max(travel.sum(), 1e-300))


def timed(subject: Subject, name: str, command: str, across: float, lag: Lag) -> Iterator[Finding]:
    """Findings about a motion that follows its command too late, or precedes it.

    `across` is the command's `pace` [s]: friction holds slow motion back by an angle, not a time.
    """
    to = "reference" if command in subject.recording else "experiment"
    mend = mends.aligned(to, lag.value)
    advice = f"convert with {', '.join(mend)}"
    margin = 3.0 * lag.deviation
    late = lag.value < -BEFORE - margin or _implausible(subject, name, lag)
    if late and lag.correlation < SAME_RUN[lag.gain > BLOCKED]:
        yield _other_run(name, command, lag.against)
        return
    if lag.value < -BEFORE - margin:
        text = f"moves {1e3 * -lag.value:.4g} ms before {command}: two clocks; {advice}"
        yield fault("late-start", name, text, size=lag.value, mend=mend)
    longest = subject.of(name).lag
    most = max(longest, HELD_BACK * across)
    if longest and lag.value > most + margin:
        text = f"moves {1e3 * lag.value:.4g} ms behind {command}, longer than the machine takes"
        found = fault if lag.value > GROSS * most + margin else warning
        yield found("late-start", name, f"{text}: {advice}", size=lag.value, mend=mend)


def _drives(subject: Subject, name: str, moved: str) -> Iterator[Finding]:
    """The sign of a drive: against both directions of motion it would only brake."""
    speed = subject.speed(moved)
    push = subject.recording[name][1:]
    fast = FAST * float(np.abs(speed).max())
    forth, back = push[speed > fast], push[speed < -fast]
    level = AGAINST * float(np.sqrt(np.mean(push**2)))
    against = forth.size > 0 and forth.mean() < -level
    if against and back.size and back.mean() > level:
        mend = mends.reversed_sign(subject, name)
        text = f"pushes against {moved} both ways: convert with {mend[0]}"
        yield fault("sign", name, text, size=float(forth.mean()), mend=mend)
    elif against:
        mend = mends.reversed_sign(subject, name)
        text = f"pushes against {moved} as it moves in + direction: is its sign reversed? "
        text += f"convert with {mend[0]}"
        yield warning("sign", name, text, size=float(forth.mean()), mend=mend)
