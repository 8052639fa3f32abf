"""Steps that inertia rules out, and single readings that are far off their neighbours."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault, warning
from hannes.campaigns.quality.held import held_frames, renewal
from hannes.campaigns.quality.sensors import stuck_runs
from hannes.campaigns.quality.subject import (
    Subject,
    alone,
    noise,
    quantum,
    running_median,
    speeds,
    sustained,
    true_runs,
)
from hannes.core.recording.median_of_few import median_of_five

FloatArray = NDArray[np.float64]

JUMP = 3.0  # times the fastest sustained move
LEAST_JUMP = 0.01  # of the channel's range
MOST = 0.05  # share of samples that may be far off, beyond which the channel is what it is
NEIGHBOURS = 5  # samples of the median with which a reading is compared
FAR = 12.0  # typical distances from that median
FAR_OF_RANGE = 0.15  # of the range without the outermost hundredths
EQUAL = 3  # outliers of one value that make it a code
MANY = 50_000  # samples that are enough for a quantile
OUTSIDE = 1.5  # ranges of the other values, by which a code lies outside them
ALIKE = 0.05  # relative, of jumps that are all of one turn
FULL = 0.9  # of a turn, that the values of a counter that wraps reach over
LIKE_BLOWS = 2.0  # ratio of what two sensors show of one blow, either way, at most
FORCE = "N"
STOOD = 5  # equal readings of a sensor that dropped out
HARDER = 2.5  # times the largest change of a step elsewhere
OFTEN = 0.1  # share of readings that are off the median of their neighbours
WIDE = 1.5  # median intervals, from which one is a gap
WORDS = 2.0**16


def inspect(subject: Subject) -> Iterator[Finding]:
    """Findings about outliers, codes for missing values, and jumps."""
    for name in subject.recording.names:
        values = subject.recording[name]
        if np.ptp(values) == 0.0 or name in subject.commands:
            continue
        if (found := _code(subject, name, values)) or (found := _unsigned(subject, name, values)):
            yield found
            continue
        odd = outliers(subject, name, values)
        if odd.any():
            yield _outliers(subject, name, values, odd)
        elif subject.is_motion(name):
            yield from _jumps(subject, name, values)


def _code(subject: Subject, name: str, values: FloatArray) -> Finding | None:
    """A number far outside of all others that stands for no value, such as -999."""
    for extreme in (values.min(), values.max()):
        same = values == extreme
        rest = values[~same]
        if not EQUAL <= np.count_nonzero(same) <= 0.3 * values.size or rest.size < EQUAL:
            continue
        span = max(float(np.ptp(rest)), 1e-12)
        apart = float(np.min(np.abs(rest - extreme)))
        raw = subject.raw(name, float(extreme))
        whole = abs(raw - round(raw)) < 1e-6 * max(abs(raw), 1.0) and abs(raw) >= 99.0
        if whole and apart > OUTSIDE * span:
            return fault(
                "missing",
                name,
                f"is {subject.with_unit(float(extreme), name)} in {np.count_nonzero(same)} "
                "samples, far outside of all others: a code for no value? convert with "
                f'missing = ["{raw:.10g}"]',
                time=float(subject.time[int(np.argmax(same))]),
                size=float(extreme),
                mend=mends.missing(subject, (f"{raw:.10g}", f"{round(raw)}.0")),
            )
    return None


def _unsigned(subject: Subject, name: str, values: FloatArray) -> Finding | None:
    """Values just below 2^16 beside small ones: integers below zero that lost their sign."""
    raw = np.array([subject.raw(name, 0.0), subject.raw(name, 1.0)])
    counts = raw[0] + (raw[1] - raw[0]) * values
    for scale in (1.0, 10.0, 100.0, 1000.0):
        whole = scale * counts
        high = whole > 0.75 * WORDS
        off = np.abs(whole - np.round(whole)).max() > 1e-3
        if off or not high.any() or whole.max() >= WORDS or whole.min() < 0.0:
            continue
        if (whole[~high] < 0.25 * WORDS).all() and (~high).any():
            text = f"jumps to {subject.with_unit(float(values.max()), name)}, 65536 counts above "
            text += "zero: numbers of 16 bits that lost their sign; convert with "
            mend: tuple[str, ...] = (f"channels.{name}.signed = 16",)
            if scale > 1.0:
                text += "signed = 16 of the raw counts, or "
                mend = _by_turn(subject, name, scale, bool(high[0]))
            return fault("signed", name, f"{text}{mend[0]}", size=WORDS, mend=mend)
    return None


def _by_turn(subject: Subject, name: str, scale: float, high: bool) -> tuple[str, ...]:
    """Jumps of one turn taken out: the same as a sign, where values change by less than half.

    What begins below zero, so is read `high`, is one turn lower throughout.
    """
    turn = WORDS / scale
    lines = (f"channels.{name}.unwrap = {turn:.10g}",)
    whole = turn / (subject.raw(name, 1.0) - subject.raw(name, 0.0))
    return (*lines, *mends.shifted(subject, name, -whole)) if high else lines


def outliers(subject: Subject, name: str, values: FloatArray) -> NDArray[np.bool_]:
    """Readings far from the median of their neighbours, which agree; shape (n,)."""
    none = np.zeros(values.size, np.bool_)
    if values.size < 4 * NEIGHBOURS:
        return none
    few = slice(None, None, max(values.size // MANY, 1))  # of which quantiles are taken
    low, high = np.quantile(values[few], (0.02, 0.98))
    least = (LEAST_JUMP if subject.is_motion(name) else FAR_OF_RANGE) * float(high - low)
    steps = np.abs(np.diff(values))
    if NEIGHBOURS // 2 * float(steps.max()) <= least:  # nothing is so far from its neighbours
        return none
    off = np.abs(values - median_of_five(values))
    most = off[off > 0.0]
    if not most.size or (subject.is_motion(name) and most.size < OFTEN * off.size):
        most = off  # of a smooth motion only outliers are off
    usual = float(np.quantile(most[:: max(most.size // MANY, 1)], 0.8)) / 1.28
    if float(off.max()) <= max(FAR * usual, least):
        return none
    typical = max(usual, quantum(values), noise(values))
    far = off > max(FAR * typical, least)
    if subject.is_motion(name):
        usual = float(np.quantile(steps[few], 0.97))
        far &= off > max(3.0 * usual, LEAST_JUMP * float(high - low))
    contradicted = _contradicted(values, off)
    contradicted |= far & _beside(contradicted & far)
    single = _brief(far & contradicted & ~_blows(subject, name, values))
    if single.any() and not subject.is_motion(name):  # smaller ones of the same kind
        single |= _brief(contradicted & (off > FAR * typical))
    return single if np.count_nonzero(single) <= MOST * values.size else none


def _blows(subject: Subject, name: str, values: FloatArray) -> NDArray[np.bool_]:
    """Forces that rise for a sample as all other forces do, shape (n,): a finger that hits.

    A blow is no larger than what the force does for longer. Codes and dropouts are none.
    """
    units = subject.recording.units
    forces = [subject.recording[n] for n in subject.recording.names if units[n] == FORCE]
    if units[name] != FORCE or len(forces) < 2:
        return np.zeros(values.size, np.bool_)
    found, off = np.ones(values.size, np.bool_), values - median_of_five(values)
    for each in forces:
        usual = median_of_five(each)
        also, span = each - usual, float(np.ptp(usual))
        found &= (np.abs(each) > np.abs(usual)) & (np.abs(also) < span) & (also * off > 0.0)
        found &= np.maximum(np.abs(also), np.abs(off)) < LIKE_BLOWS * np.minimum(
            np.abs(also), np.abs(off)
        )
    return found


def _contradicted(values: FloatArray, off: FloatArray) -> NDArray[np.bool_]:
    """Whether neighbours agree on another value, and no smooth curve through them has it, (n,).

    A drive's inrush or its braking, which few samples resolve, has other neighbours, or a curve:
    the middle two of four differ by much of what it is off, or a cubic through them is near.
    """
    padded = np.pad(values, 2, mode="edge")
    four = np.array([padded[k : k + values.size] for k in (0, 1, 3, 4)])
    curve = np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0 @ four
    around = np.sort(four, axis=0)
    return (around[2] - around[1] < 0.5 * off) & (np.abs(values - curve) > 0.25 * off)


def _beside(some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The samples next to some, shape (n,): of two bad readings one may hide the other."""
    found = np.zeros_like(some)
    found[1:] = some[:-1]
    found[:-1] |= some[1:]
    return found


def _brief(far: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The runs that are too short to be anything but outliers."""
    found = np.zeros_like(far)
    for first, last in true_runs(far):
        found[first : last + 1] = last - first + 1 <= NEIGHBOURS // 2
    return found


def _outliers(subject: Subject, name: str, values: FloatArray, odd: NDArray[np.bool_]) -> Finding:
    runs = true_runs(odd)
    first = runs[0][0]
    many = f"{np.count_nonzero(odd)} reading{'s' if np.count_nonzero(odd) > 1 else ''}"
    worst = float(np.abs(values - running_median(values))[odd].max())
    level = fault if subject.is_motion(name) else warning
    return level(
        "jump",
        name,
        f"{many} far off their neighbours, by up to {subject.with_unit(worst, name)}: outliers; "
        "leave them out (time.cut)",
        time=float(subject.time[first]),
        size=worst,
        mend=mends.cut(subject, runs, name),
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
    beyond &= np.diff(subject.time) < WIDE * subject.interval  # over a gap it may go far
    beyond |= _at_rest(steps, least) & (np.diff(subject.time) < WIDE * subject.interval)
    for _, last in stuck_runs(subject, name, values):
        beyond[min(last, beyond.size - 1)] = False  # it catches up with what it missed
    places = np.flatnonzero(beyond & (odd > least))
    if not places.size or places.size > values.size / 20:
        return
    worst = int(places[np.argmax(odd[places])])
    advice, mend = _jump_advice(subject, name, steps - usual * np.diff(subject.time), places)
    yield fault(
        "jump",
        name,
        f"{places.size} step{'s' if places.size > 1 else ''} faster than anything moves, the "
        f"largest {subject.with_unit(float(steps[worst]), name)} "
        f"at {subject.time[worst + 1]:.4g} s: {advice}",
        time=float(subject.time[places[0] + 1]),
        size=float(steps[worst]),
        mend=mend,
    )


def _stood_since(values: FloatArray, place: int) -> int:
    """The sample before a jump; of equal readings before it, of a sensor that stood, the first."""
    changes = np.flatnonzero(np.diff(values[: place + 1]))
    if not changes.size or place - changes[-1] < STOOD:
        return place
    return int(changes[-1]) + 1


def _at_rest(steps: FloatArray, least: float) -> NDArray[np.bool_]:
    """Steps with rest before and after them, that start and stop far harder than any motion."""
    single = alone(steps, least)
    if not single.any() or steps.size < 2:
        return np.zeros_like(single)
    near = np.flatnonzero(single)[:, None] + np.arange(-2, 2)
    change = np.abs(np.diff(steps))
    others = np.delete(change, np.unique(np.clip(near, 0, change.size - 1)))
    return np.asarray(single & (np.abs(steps) > HARDER * float(others.max(initial=0.0))))


def _jump_advice(
    subject: Subject, name: str, steps: FloatArray, places: NDArray[np.intp]
) -> tuple[str, tuple[str, ...]]:
    first = int(places[0])
    worst = int(places[np.argmax(np.abs(steps[places]))])
    rest = mends.rest(subject, _stood_since(subject.recording[name], first) + 1)
    for other in subject.commands & set(subject.recording.names):
        moves = np.abs(np.diff(subject.recording[other]))
        if moves[worst] > JUMP * np.median(moves) and moves[worst] > 0.3 * abs(steps[worst]):
            text = f"{other} steps there too, so samples were lost though the times run on evenly"
            return f"{text}; leave out what follows (time.cut)", rest
    turn = float(np.median(np.abs(steps[places])))
    alike = float(np.abs(np.abs(steps[places]) / turn - 1.0).max()) < ALIKE
    span = float(np.ptp(subject.recording[name]))
    if alike and FULL * turn < span <= (1.0 + ALIKE) * turn:
        raw = abs(subject.raw(name, turn) - subject.raw(name, 0.0))
        text = f"a counter that wraps round; convert with channels.{name}.unwrap = {raw:.6g}"
        return text, (f"channels.{name}.unwrap = {raw:.9g}",)
    return "the encoder lost count; leave out what follows (time.cut)", rest
