"""Each channel by itself: clipped, frozen, dead, jumping; its noise and its resolution."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, note, warning
from hannes.campaigns.quality.held import held_frames, renewal
from hannes.campaigns.quality.subject import (
    Subject,
    levels,
    noise,
    quantum,
    true_runs,
)

FloatArray = NDArray[np.float64]

DRIVEN = ("A", "V", "N", "N m")  # units of quantities that do not rest on a stop
# Samples of a flat top. Of 6000 noisy bell-shaped peaks (15 samples wide, noise of two steps) four
# equal readings on top were taken for a clipped sensor in 12, three in 45, five in none.
SHORTEST_TOP = 5
LONG_TOP = 12  # samples at the extreme, of a noisy channel, that no chance gives
# Noise in steps, from which readings do not pile up at an extreme, how many do, and times how many
# are at each of the steps before it.
DITHERED, FEWEST_PILED, PILED = 0.8, 15, 2.5
ENTRY = 3  # samples before and after a flat top that give its slope
ABRUPT = 3.0  # quantisation steps from sample to sample; less than one at a round top
FEWEST_LEVELS = 8  # a signal of fewer values is switched, not measured
FEWEST_COARSE = 3  # values of a driven quantity, that is measured
CAUGHT_UP = 2.5  # following steps, by which a reading that was stuck catches up
FEWEST_STUCK = 5  # equal readings of a position that moves
LEAST_FROZEN = 14  # samples without any change, where there is noise otherwise
REPEATS = 0.2  # share of repeated values from which a channel is at rest
RARE = 4  # times longer than any other run of one value
# RMS of what a motion went while its reading stood, of its range, and share of a recording that is
# cut off: by which a fit is misled.
GROSS_STUCK, GROSS_TOP = 0.015, 0.1
WIDE = 1.5  # median intervals, over which a motion may go far
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
            yield from _stuck(subject, name, values) if subject.is_motion(name) else _frozen(
                subject, name, values)  # fmt: skip
        yield from _resolution(subject, name, values)


def _dead(subject: Subject, name: str) -> Finding:
    """A channel that never moves: a fault where the plant says that something must move it."""
    recording, expected = subject.recording, subject.of(name)
    value = subject.with_unit(float(recording[name][0]), name)
    driving = [n for n, each in subject.expected.items() if each.drives == name and n in recording]
    other = next((n for n in (expected.follows, expected.drives, *driving)
                  if n in recording and np.ptp(recording[n]) > 0.0), "")  # fmt: skip
    if other:
        return fault(
            "dead",
            name,
            f"stays at {value} while {other} moves by "
            f"{subject.with_unit(float(np.ptp(recording[other])), other)}: leave the channel out, "
            "or check its sensor and its column",
            mend=mends.without(subject, name),
        )
    return note("dead", name, f"stays at {value} throughout")


def _clipped(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """Flat tops, entered at a slope that would continue beyond them."""
    expected = subject.of(name)
    declared = expected.drives or expected.limit
    if not declared and subject.recording.units[name] not in DRIVEN:
        return
    if levels(values) < FEWEST_LEVELS:
        return
    for side, extreme in (("largest", values.max()), ("smallest", values.min())):
        tops = _flat_tops(values, float(extreme)) or _as_far_both_ways(values, float(extreme))
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
            "widen the range, or leave these samples out (time.cut)"
        )
        mend = mends.cut(subject, true_runs(values == extreme), name)
        found = fault if count > GROSS_TOP * values.size and expected.drives else warning
        yield found("saturated", name, text, time=start, size=lasting, mend=mend)


def _flat_tops(values: FloatArray, extreme: float) -> list[tuple[int, int]]:
    """Runs at the extreme: any where noise is clipped away, else those entered at speed."""
    if extreme == 0.0:  # a rest, not a range
        return []
    span, step = float(np.ptp(values)), quantum(values)
    inward = np.abs(values - extreme)
    tops = true_runs(inward <= 1e-9 * span)
    tops = [each for each in tops if each[1] - each[0] + 1 >= SHORTEST_TOP]
    if not tops and np.count_nonzero(inward < 0.5 * step) < FEWEST_PILED:
        return []
    others = values[values != extreme]  # most may be cut off
    rough = max(noise(values), noise(others)) if others.size > FEWEST_LEVELS else noise(values)
    if rough > 3.0 * step:
        return tops
    if rough > 0.0 and (long := _long_tops(values, tops)):
        return long
    if rough > DITHERED * step > 0.0 and _piled(values, extreme, step):
        return true_runs(np.abs(values - extreme) <= 1e-9 * span)
    step = max(step, 1e-9 * span)
    return [(first, last) for first, last in tops if _abrupt(values, first, last, step)]


def _as_far_both_ways(values: FloatArray, extreme: float) -> list[tuple[int, int]]:
    """Long runs at an extreme that is as far the other way, and long there too: a range ends."""
    if abs(float(values.max() + values.min())) > 0.5 * quantum(values):
        return []
    runs = true_runs(np.abs(values) >= abs(extreme) - 1e-9 * float(np.ptp(values)))
    long = [each for each in runs if each[1] - each[0] + 1 >= LONG_TOP]
    there = [each for each in long if values[each[0]] * extreme > 0.0]
    many = sum(last - first + 1 for first, last in long) > GROSS_TOP * values.size
    return there if many and 0 < len(there) < len(long) else []


def _long_tops(values: FloatArray, tops: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Runs at the extreme far longer than any other run of one value of a noisy channel."""
    inside = np.zeros(values.size - 1, np.bool_)
    for first, last in tops:
        inside[first:last] = True
    others = true_runs((np.diff(values) == 0.0) & ~inside)
    natural = max((last - first + 2 for first, last in others), default=1)
    longest = max((last - first + 1 for first, last in tops), default=0)
    return tops if longest >= max(LONG_TOP, RARE * natural) else []


def _piled(values: FloatArray, extreme: float, step: float) -> bool:
    """Whether far more readings are at the extreme than at the steps before it."""
    inward = -step if extreme > float(np.median(values)) else step
    there, *near = (
        np.count_nonzero(np.abs(values - extreme - k * inward) < 0.5 * step) for k in range(4)
    )
    return bool(there >= FEWEST_PILED and there > PILED * max(float(np.mean(near)), 1.0))


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
    if not still:
        return
    first, last = max(still, key=lambda each: each[1] - each[0])
    elsewhere = np.delete(same, np.arange(first, last + 1))
    others = [end - start for start, end in still if start != first]
    natural = max(others, default=0) + 1  # noise on a coarse scale repeats itself, but briefly
    if last - first + 2 < max(LEAST_FROZEN, RARE * natural) or elsewhere.mean() > REPEATS:
        return
    rest = np.delete(values, np.arange(first, last + 1))  # it may be most of it
    if noise(rest) == 0.0 or values[first] in (values.min(), values.max()):
        return  # no noise to stand out from, or reported as clipped
    lasting = float(subject.time[last + 1] - subject.time[first])
    yield warning(
        "frozen",
        name,
        f"exactly {subject.with_unit(float(values[first]), name)} for {lasting:.3g} s though it is "
        "noisy otherwise: the sensor dropped out, or a dead band holds it; leave it "
        "out (time.cut)",
        time=float(subject.time[first]),
        size=lasting,
        mend=mends.cut(subject, [(first, last + 1)], name),
    )


def _stuck(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """Equal readings of a position that then catches up at once with what it missed."""
    runs = stuck_runs(subject, name, values)
    if not runs:
        return
    first, last = max(runs, key=lambda each: each[1] - each[0])
    lasting = float(subject.time[last] - subject.time[first])
    missed = sum(_missed(values, *each) for each in runs) / values.size
    found = fault if missed > (GROSS_STUCK * float(np.ptp(values))) ** 2 else warning
    yield found(
        "frozen",
        name,
        f"stays at {subject.with_unit(float(values[first]), name)} for {lasting:.3g} s and then "
        "catches up at once: the sensor dropped out; leave these samples out (time.cut)",
        time=float(subject.time[first]),
        size=lasting,
        mend=mends.cut(subject, runs, name),
    )


def _missed(values: FloatArray, first: int, last: int) -> float:
    """Sum of squares of what a motion went meanwhile, taken as even."""
    return float(values[last + 1] - values[first]) ** 2 * (last - first + 1) / 3.0


def stuck_runs(subject: Subject, name: str, values: FloatArray) -> list[tuple[int, int]]:
    """First and last index of such readings."""
    steps, step = np.diff(values), quantum(values)
    if renewal(subject, name) > 1 or held_frames(subject).any():
        return []
    even = np.diff(subject.time) < WIDE * subject.interval
    runs = []
    for first, last in true_runs(steps == 0.0):
        if last - first + 2 < FEWEST_STUCK or not 4 < first or last + 5 > steps.size:
            continue
        if not even[last + 1] or abs(steps[last + 1]) < 2.0 * CAUGHT_UP * step:
            continue
        before, after = (float(np.median(each)) for each in (
            steps[first - 4 : first], steps[last + 2 : last + 6]))  # fmt: skip
        missed = 0.5 * (abs(before) + abs(after)) * (last - first + 1)
        leap = abs(float(steps[last + 1]))
        usual = max(abs(before), abs(after), 2.0 * step)
        if leap > CAUGHT_UP * usual and 0.3 * missed < leap < 4.0 * missed:
            runs.append((first, last + 1))
    return runs


def _resolution(subject: Subject, name: str, values: FloatArray) -> Iterator[Finding]:
    """What the channel resolves at best: noise and quantisation step."""
    rough, step, span = noise(values), quantum(values), float(np.ptp(values))
    shown = f"noise {subject.with_unit(rough, name)}, "
    shown += f"step {subject.with_unit(step, name)}" if step else "no quantisation step seen"
    shown += f", from {values.min():.4g} to {subject.with_unit(float(values.max()), name)}"
    yield note("resolution", name, shown, size=rough)
    measured = name not in subject.commands and values.size >= FEWEST_LEVELS
    dithered = noise(values) > 0.5 * step  # noise resolves values between the steps
    fewest = FEWEST_COARSE if subject.of(name).drives else FEWEST_LEVELS
    many = levels(values) >= fewest
    if measured and step * COARSE > span and many and not dithered:
        text = f"only {span / step:.0f} steps of {subject.with_unit(step, name)} cover its range"
        mend = mends.without(subject, name)
        text = f"{text}: choose a finer range, or leave the channel out"
        yield warning("coarse", name, text, size=step, mend=mend)
