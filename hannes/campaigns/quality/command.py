"""The recorded command against that of the experiment: its unit, its clock, its start."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.raw_values import usual_rate
from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, note, warning
from hannes.campaigns.quality.motion import UNLIKE, found_lag, pace, timed, unlike
from hannes.campaigns.quality.retimed import pace_of, refuted
from hannes.campaigns.quality.subject import Plan, Subject
from hannes.campaigns.quality.zero import begins_moving
from hannes.core.recording.time_lag import Lag

FloatArray = NDArray[np.float64]

SAME = 0.02  # of the range, that a command may differ from the plan and still be the same
# RMS of a recorded command at its best pace, of its range, and that pace, that are another one's.
OTHER_SHAPE, OTHER_PACE = 0.1, 0.1
LEAST_DRIFT = 1e-3  # of the clock's rate
GROSS_DRIFT = 1e-2  # beyond which a fit is misled
GROSS_PACE = 0.06  # of the rate, by the motion alone, which lags its command
FITS = 0.08  # of the range, that a motion may be off the experiment's command and still be of it
ROUGHLY = 0.12  # the same, of one that lags by more than it can, and at another pace
FACTOR = 0.05  # relative, about a factor that a mistake would make
LEAST_PACE = 3e-3  # of the rate of a recorded command, by which a motion may differ
WHOLE = 0.85  # of the experiment's command, that a recording covers by which a rate is judged
ROUND = 0.01  # relative, by which a rounder sampling rate is taken
AGREE = 0.2  # by which the pace of a motion, which lags, may differ from that of its controller
OWN_LAG = 2.5  # of its error of fit over its range, by which a machine's own lag looks like a rate
ENOUGH = 4000  # samples by which a rate is found
ROUNDS = 30


def inspect(subject: Subject, plan: Plan, command: str = "reference") -> Iterator[Finding]:
    """Findings about the recording against its experiment."""
    if command in subject.recording:
        yield from _recorded(subject, plan, command)
        return
    for name, expected in subject.expected.items():
        if expected.follows == command and name in subject.recording:
            yield from _unrecorded(subject, plan, name)


def _unrecorded(subject: Subject, plan: Plan, name: str) -> Iterator[Finding]:
    """A motion without a recorded command, against that of the experiment."""
    what, motion = "the experiment's command", subject.recording[name]
    if np.ptp(plan.values) == 0.0:
        return
    if np.ptp(motion) == 0.0:
        text = f"stays at {subject.with_unit(float(motion[0]), name)} while {what} moves by "
        text += f"{np.ptp(plan.values):.4g}: check its sensor and its column, or the experiment"
        yield fault("dead", name, text, mend=mends.NO_FILE)
        return
    lag = found_lag(subject, motion, plan.times, plan.values)
    if lag is None or lag.against > UNLIKE:
        other = found_lag(subject, -motion, plan.times, plan.values)
        if other is not None and other.against <= UNLIKE and motion.max() < -motion.min():
            return  # its sign is reversed, which its magnitude says
        yield from unlike(subject, name, what, plan.times, plan.values)
    else:
        found = list(timed(subject, name, what, pace(plan.times, plan.values), lag))
        instead = (*_paced(subject, name, plan), *_of_another(subject, name, plan, lag))
        yield from instead[:1] if found and instead else found


def _of_another(subject: Subject, name: str, plan: Plan, lag: Lag) -> Iterator[Finding]:
    """A motion far from its experiment's command that follows it less far at another pace."""
    motion, time = subject.recording[name], subject.time
    if subject.time[-1] < WHOLE * float(plan.times[-1]) or begins_moving(subject, name):
        return
    few = slice(None, None, max(time.size // ENOUGH, 1))
    as_far = Plan(plan.times, plan.values * float(np.ptp(motion) / np.ptp(plan.values)))
    moved = motion[few] - motion[0] + as_far.values[0]
    rate, rest = _clock(time[few], moved, as_far)
    late = np.interp(time[few] - lag.value, as_far.times, as_far.values)
    before = float(np.sqrt(np.mean((moved - late) ** 2)))
    if abs(rate - 1.0) < OTHER_PACE or rest > min(ROUGHLY * float(np.ptp(motion)), before / 2.0):
        return
    text = f"takes {1.0 / rate:.3g} times as long as the experiment's command, and goes to "
    text += f"{subject.with_unit(float(motion.max()), name)} "
    text += f"({subject.with_unit(float(plan.values.max()), name)}): another experiment, or its "
    text += "speed was another; name the right one, or write its command"
    yield fault("unlike", name, text, size=1.0 / rate, mend=mends.NO_FILE)


def _paced(subject: Subject, name: str, plan: Plan) -> Iterator[Finding]:
    """A motion that takes another time than the experiment: the clock runs at another rate."""
    size, end = float(np.ptp(plan.values)), float(plan.times[-1])
    if subject.time[-1] < WHOLE * end or begins_moving(subject, name):
        return  # of a part, a lag looks like a rate
    rate, rest = _clock(subject.time, subject.recording[name], plan)
    if abs(rate - 1.0) > GROSS_PACE and rest < FITS * size:
        yield _drift(subject, "time", rate, fault, _clock_or_speed(subject, rate))


def _clock_or_speed(subject: Subject, rate: float) -> tuple[str, ...]:
    """Lines for a wrong clock, where its rate is then a usual one; else it was the speed."""
    now = (len(subject.recording) - 1) / float(subject.time[-1] - subject.time[0])
    true = usual_rate(now / rate, ROUND)
    if true is None or abs(true / now - 1.0) < ROUND / 4.0:
        return mends.NO_FILE
    return mends.rate(subject, true)


def _advice(mend: tuple[str, ...]) -> str:
    return "leave the file out" if mend == mends.NO_FILE else f"convert with {mend[0]}"


def paces(subject: Subject) -> Iterator[Finding]:
    """Motions that take another time than their recorded command."""
    for name, expected in subject.expected.items():
        command = expected.follows
        if name not in subject.recording or command not in subject.recording:
            continue
        plan = Plan(subject.time, subject.recording[command])
        size = float(np.ptp(plan.values))
        still = np.ptp(subject.recording[name]) == 0.0
        if size == 0.0 or still or begins_moving(subject, name):
            continue
        rate, rest = _paced_as(subject, name, plan)
        least = OTHER_PACE if _ends_on_its_way(plan) else LEAST_PACE
        far = abs(rate - 1.0) > max(least, OWN_LAG * rest / size)
        if rest < FITS * size and far and not refuted(subject, rate, name):
            yield _pace(name, command, rate)


def _ends_on_its_way(plan: Plan) -> bool:
    """Whether a command goes one way to its last sample: there a late start looks like a pace."""
    steps = np.diff(plan.values)
    one_way = bool((steps >= 0.0).all() or (steps <= 0.0).all())
    last = steps[-max(steps.size // 20, 1) :]
    return one_way and abs(float(np.mean(last))) > 0.5 * abs(float(np.mean(steps)))


def _paced_as(subject: Subject, name: str, plan: Plan) -> tuple[float, float]:
    """Pace of a motion by itself, and the rms of what is left."""
    few = slice(None, None, max(subject.time.size // ENOUGH, 1))
    motion = subject.recording[name] - (subject.recording[name][0] - plan.values[0])
    return _clock(subject.time[few], motion[few], plan)


def _pace(name: str, command: str, rate: float) -> Finding:
    text = f"does not follow {command} in time, it takes {1.0 / rate:.4g} times as long "
    text += "the same way: its speed was overridden, the two have different clocks, or they are of "
    text += "two runs; record the command as it was carried out"
    return fault("pace", name, text, size=1.0 / rate, mend=mends.NO_FILE)


def retimed(subject: Subject) -> Iterator[Finding]:
    """Another pace than that of the command, by the law of the controller."""
    pace = pace_of(subject)
    if pace is None:
        yield from paces(subject)
        yield from _by_motion(subject)
        return
    for name, expected in subject.expected.items():
        if expected.follows and name in subject.recording:
            asked = subject.asked_at(name)
            if begins_moving(subject, name) or asked is None:
                continue
            if abs(_paced_as(subject, name, Plan(*asked))[0] - pace) > AGREE:
                continue
            recorded = expected.follows in subject.recording
            yield _pace(name, expected.follows, pace) if recorded else _drift(
                subject, "time", pace, fault, _clock_or_speed(subject, pace))  # fmt: skip
            return


def _by_motion(subject: Subject) -> Iterator[Finding]:
    """Another pace than the experiment's, by the motion alone."""
    for name, expected in subject.expected.items():
        if subject.plan is None or expected.follows in subject.recording:
            continue
        if expected.follows and name in subject.recording and np.ptp(subject.recording[name]):
            yield from _paced(subject, name, subject.plan)


def _recorded(subject: Subject, plan: Plan, command: str) -> Iterator[Finding]:
    time, values = subject.time, subject.recording[command]
    size = float(np.ptp(plan.values))
    if size == 0.0 or np.ptp(values) == 0.0:
        return
    gain = float(np.ptp(values)) / size
    for what, factor in subject.of(command).mistakes.items():
        if abs(gain / factor - 1.0) < FACTOR or abs(gain * factor - 1.0) < FACTOR:
            text = f"is {gain:.4g} times the experiment's: {what} ({factor:.4g})?"
            mend = mends.of_mistake(subject, command, gain, what)
            yield fault("unit", command, f"{text} convert with {mend[0]}", size=gain, mend=mend)
            return
    rate, rest = _clock(time, values, plan)
    if rest > SAME * size:
        yield _another(subject, plan, command, rate, rest / size)
        return
    yield from _drifting(subject, command, rate)


def _another(subject: Subject, plan: Plan, command: str, rate: float, rest: float) -> Finding:
    """A recorded command of another shape; `rest`: RMS that is left at its best pace, of its range.

    It drives the simulation, so alone it does no harm; an object of the experiment is then where
    it was not, or not when it was.
    """
    text = "is not that of the experiment"
    gross = rest > OTHER_SHAPE or abs(rate - 1.0) > OTHER_PACE
    if not gross or not plan.touches:
        text += ": what was recorded drives the simulation"
        level = warning if gross else note
        more = ", as a free closure; leave experiment out, or name the right one" if gross else ""
        return level("command", command, text + more, size=rest)
    asked, end = subject.recording[command], float(plan.times[-1])
    moving = float(subject.time[np.flatnonzero(np.diff(asked) != 0.0)[-1] + 1])
    text += f" (it ends at {moving:.4g} s and goes to {subject.with_unit(asked.max(), command)}, "
    text += f"the experiment's at {end:.4g} s and {subject.with_unit(plan.values.max(), command)})"
    text += ": another run, or the wrong experiment, whose object is not there; name the right "
    text += "one, or write it with this command as its reference"
    return fault("command", command, text, size=rest, mend=mends.NO_FILE)


def _drifting(subject: Subject, command: str, rate: float) -> Iterator[Finding]:
    off = abs(rate - 1.0) * float(subject.time[-1] - subject.time[0])
    if abs(rate - 1.0) < LEAST_DRIFT or off < subject.interval:
        return
    yield _drift(subject, command, rate, fault if abs(rate - 1.0) > GROSS_DRIFT else warning)


def _drift(
    subject: Subject,
    channel: str,
    rate: float,
    level: Callable[..., Finding],
    mend: tuple[str, ...] = (),
) -> Finding:
    span = float(subject.time[-1] - subject.time[0])
    mend = mend or mends.rate(subject, (len(subject.recording) - 1) / (rate * span))
    return level(
        "drift",
        channel,
        f"the recording's clock runs {100 * (1.0 / rate - 1.0):+.3g} % against the experiment's, "
        f"{1e3 * abs(rate - 1.0) * span:.3g} ms over the recording (or its speed was overridden): "
        f"take the times of the controller's clock, or {_advice(mend)}",
        size=1.0 / rate - 1.0,
        mend=mend,
    )


def _clock(time: FloatArray, values: FloatArray, plan: Plan) -> tuple[float, float]:
    """Best-fit rate of time of the plan, and the rms of the residual; the shift is free."""
    starts = [_fitted(time, values, plan, shift) for shift in _starts(time, values, plan)]
    return min(starts, key=lambda each: each[1])


def _starts(time: FloatArray, values: FloatArray, plan: Plan) -> list[float]:
    """No shift, and the one at which both first leave their start."""
    moved = np.flatnonzero(np.abs(values - values[0]) > SAME * np.ptp(values))
    asked = np.interp(time, plan.times, plan.values)
    left = np.flatnonzero(np.abs(asked - asked[0]) > SAME * np.ptp(plan.values))
    offset = float(time[moved[0]] - time[left[0]]) if moved.size and left.size else 0.0
    return [0.0, offset]


def _fitted(time: FloatArray, values: FloatArray, plan: Plan, shift: float) -> tuple[float, float]:
    """Gauss-Newton on plan(rate * (t - t0) + t0 - shift), from one shift [s]."""
    rate, since = 1.0, time - time[0]
    for _ in range(ROUNDS):
        at = time[0] + rate * since - shift
        slope = _slope(plan, at)
        rest = values - np.interp(at, plan.times, plan.values)
        columns = np.column_stack((-slope, slope * since))
        move, *_ = np.linalg.lstsq(columns, rest, rcond=None)
        shift, rate = shift + float(move[0]), float(np.clip(rate + move[1], 0.5, 2.0))
        if np.abs(move).max() < 1e-9:
            break
    rest = values - np.interp(time[0] + rate * since - shift, plan.times, plan.values)
    return rate, float(np.sqrt(np.mean(rest**2)))


def _slope(plan: Plan, at: FloatArray) -> FloatArray:
    tiny = 1e-3 * float(plan.times[-1] - plan.times[0])
    ahead, behind = (np.interp(at + d, plan.times, plan.values) for d in (tiny, -tiny))
    return np.asarray((ahead - behind) / (2.0 * tiny))
