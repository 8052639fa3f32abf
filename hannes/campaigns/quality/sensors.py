"""Each channel by itself: clipped, frozen, dead, jumping; its noise and its resolution."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality.finding import Finding, fault, note, warning
from hannes.campaigns.quality.held import held_frames, renewal
from hannes.campaigns.quality.subject import (
    Subject,
    noise,
    quantum,
    running_median,
    speeds,
    sustained,
    true_runs,
)

FloatArray = NDArray[np.float64]

DRIVEN = ("A", "V", "N", "N m")  # units of quantities that do not rest on a stop
# Samples of a flat top. Of 6000 noisy bell-shaped peaks (15 samples wide, noise of two steps) four
# equal readings on top were taken for a clipped sensor in 12, three in 45, five in none.
SHORTEST_TOP = 5
LONG_TOP = 12  # samples at the extreme, of a noisy channel, that no chance gives
ENTRY = 3  # samples before and after a flat top that give its slope
ABRUPT = 3.0  # quantisation steps from sample to sample; less than one at a round top
FEWEST_LEVELS = 8  # a signal of fewer values is switched, not measured
LEAST_FROZEN = 20  # samples without any change, where there is noise otherwise
REPEATS = 0.2  # share of repeated values from which a channel is at rest
RARE = 4  # times longer than any other run of one value
JUMP = 3.0  # times the fastest sustained move
LEAST_JUMP = 0.01  # of the channel's range
COARSE = 50.0  # steps in the range, below which resolution is poor


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about single channels."""
    for name in subject.recording.names:
        values = subject.recording[name]
        if np.ptp(values) == 0.0:
            yield _dead(subject, name)
            continue
        if name not in subject.commands:
            yield from _clipped(subject, name, values)
            yield from _frozen(subject, name, values)
        if subject.is_motion(name):
            yield from _jumps(subject, name, values)
        yield from _resolution(subject, name, values)


def _dead(subject: Subject, name: str) -> Finding:
    """A channel that never moves: a fault where the plant says that something must move it."""
    recording, expected = subject.recording, subject.of(name)
    value = subject.with_unit(float(recording[name][0]), name)
    other = expected.follows or expected.drives
    if other in recording and np.ptp(recording[other]) > 0.0:
        return fault(
            "dead",
            name,
            f"stays at {value} while {other} moves by "
            f"{subject.with_unit(float(np.ptp(recording[other])), other)}: leave the channel out, "
            "or check its sensor and its column",
        )
    return note("dead", name, f"stays at {value} throughout")


def _clipped(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """Flat tops, entered at a slope that would continue beyond them."""
    expected = subject.of(name)
    declared = expected.drives or expected.limit
    if not declared and subject.recording.units[name] not in DRIVEN:
        return
    if np.unique(values).size < FEWEST_LEVELS:
        return
    for side, extreme in (("largest", values.max()), ("smallest", values.min())):
        tops = _flat_tops(values, float(extreme))
        if not tops:
            continue
        count = sum(last - first + 1 for first, last in tops)
        lasting = float(count * subject.interval)
        limit, value = expected.limit, subject.with_unit(float(extreme), name)
        start = float(subject.time[tops[0][0]])
        if limit and abs(abs(extreme) - limit) < 0.02 * limit:
            text = f"at its limit {value} for {lasting:.3g} s: the drive is saturated there"
            yield note("saturated", name, text, time=start, size=lasting)
            continue
        text = (
            f"flat at its {side} value {value} for {lasting:.3g} s: its sensor clips or holds; "
            "widen the range, or cut these samples out"
        )
        yield warning("saturated", name, text, time=start, size=lasting)


def _flat_tops(values: FloatArray, extreme: float) -> list[tuple[int, int]]:
    """Runs at the extreme: any where noise is clipped away, else those entered at speed."""
    if extreme == 0.0:  # a rest, not a range
        return []
    span, rough, step = float(np.ptp(values)), noise(values), quantum(values)
    tops = true_runs(np.abs(values - extreme) <= 1e-9 * span)
    tops = [each for each in tops if each[1] - each[0] + 1 >= SHORTEST_TOP]
    if rough > 3.0 * step:
        return tops
    if rough > 0.0 and (long := _long_tops(values, tops)):
        return long
    step = max(step, 1e-9 * span)
    return [(first, last) for first, last in tops if _abrupt(values, first, last, step)]


def _long_tops(values: FloatArray, tops: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Runs at the extreme far longer than any other run of one value of a noisy channel."""
    inside = np.zeros(values.size - 1, np.bool_)
    for first, last in tops:
        inside[first:last] = True
    others = true_runs((np.diff(values) == 0.0) & ~inside)
    natural = max((last - first + 2 for first, last in others), default=1)
    longest = max((last - first + 1 for first, last in tops), default=0)
    return tops if longest >= max(LONG_TOP, RARE * natural) else []


def _abrupt(values: FloatArray, first: int, last: int, step: float) -> bool:
    """Whether a run is entered and left at speed; one that only ends so is a held reading."""
    before = values[max(first - ENTRY, 0) : first + 1]
    after = values[last : last + ENTRY + 1]
    if before.size <= ENTRY:
        return False
    ends = [before] if after.size <= ENTRY else [before, after]
    return min(abs(float(each[-1] - each[0])) / ENTRY for each in ends) > ABRUPT * step


def _frozen(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """A run of one value in a channel that is noisy otherwise."""
    same = np.diff(values) == 0.0
    still = true_runs(same)
    if not still or noise(values) == 0.0:
        return
    first, last = max(still, key=lambda each: each[1] - each[0])
    elsewhere = np.delete(same, np.arange(first, last + 1))
    others = [end - start for start, end in still if start != first]
    natural = max(others, default=0) + 1  # noise on a coarse scale repeats itself, but briefly
    if last - first + 2 < max(LEAST_FROZEN, RARE * natural) or elsewhere.mean() > REPEATS:
        return
    if values[first] in (values.min(), values.max()):
        return  # reported as clipped
    lasting = float(subject.time[last + 1] - subject.time[first])
    yield warning(
        "frozen",
        name,
        f"exactly {subject.with_unit(float(values[first]), name)} for {lasting:.3g} s though it is "
        "noisy otherwise: the sensor dropped out, or a dead band holds it; cut these samples out",
        time=float(subject.time[first]),
        size=lasting,
    )


def _jumps(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """Steps from one sample to the next that inertia rules out."""
    if renewal(subject, name) > 1:
        return
    speed, steps = speeds(subject.time, values), np.diff(values)
    usual = running_median(speed)
    fastest = sustained(speed)
    beyond = np.abs(speed - usual) > JUMP * fastest
    odd = np.abs(steps - usual * np.diff(subject.time))
    least = max(8.0 * quantum(values), 12.0 * noise(values), LEAST_JUMP * float(np.ptp(values)))
    beyond &= ~held_frames(subject)[:-1]  # what follows a frame that was held
    places = np.flatnonzero(beyond & (odd > least))
    if not places.size or places.size > values.size / 20:
        return
    worst = int(places[np.argmax(odd[places])])
    yield fault(
        "jump",
        name,
        f"{places.size} step{'s' if places.size > 1 else ''} faster than anything moves, the "
        f"largest {subject.with_unit(float(steps[worst]), name)} "
        f"at {subject.time[worst + 1]:.4g} s: "
        f"{_jump_advice(subject, steps[worst], worst)}",
        time=float(subject.time[places[0] + 1]),
        size=float(steps[worst]),
    )


def _jump_advice(subject: Subject, step: float, place: int) -> str:
    for name in subject.commands & set(subject.recording.names):
        moves = np.abs(np.diff(subject.recording[name]))
        if moves[place] > JUMP * np.median(moves) and moves[place] > 0.3 * abs(step):
            return f"{name} steps there too, so samples were lost though the times run on evenly"
    return "the encoder lost count or wrapped round; unwrap it, or cut the recording there"


def _resolution(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """What the channel resolves at best: noise and quantisation step."""
    rough, step, span = noise(values), quantum(values), float(np.ptp(values))
    shown = f"noise {subject.with_unit(rough, name)}, "
    shown += f"step {subject.with_unit(step, name)}" if step else "no quantisation step seen"
    shown += f", from {values.min():.4g} to {subject.with_unit(float(values.max()), name)}"
    yield note("resolution", name, shown, size=rough)
    measured = name not in subject.commands and values.size >= FEWEST_LEVELS
    dithered = noise(values) > 0.5 * step  # noise resolves values between the steps
    many = np.unique(values).size >= FEWEST_LEVELS
    if measured and step * COARSE > span and many and not dithered:
        text = f"only {span / step:.0f} steps of {subject.with_unit(step, name)} cover its range"
        yield warning("coarse", name, f"{text}: choose a finer range", size=step)
