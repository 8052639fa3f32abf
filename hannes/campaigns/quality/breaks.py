"""A law of the drive that changes within a run: a range was switched, an encoder slips.

Looked for where nothing else is wrong: most other faults break a law too.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.quality import mends
from hannes.campaigns.quality.finding import Finding, fault
from hannes.campaigns.quality.law import Relation, laws, pushes_away
from hannes.campaigns.quality.law_break import FAR_LEFT, Break, breaks_of
from hannes.campaigns.quality.motion import other_way_round
from hannes.campaigns.quality.subject import Subject, quantum

FloatArray = NDArray[np.float64]

# Share of a law's squared residual that a break explains, and what it leaves of the whole.
SHARE = {"range": 0.8, "slip of winding": 0.75, "slip of controller": 0.95}
LEFT = {"range": 0.03, "slip of winding": 0.08, "slip of controller": 0.08}
ALL, BROKEN, HELD = 0.96, 0.6, 0.2  # the same where a law does not hold at all without a slip
END, MOSTLY = 0.05, 0.8  # of a drive's range, and of a slip, in which it is there
NEAR, JUMPS = 2, 0.5  # parts about a switch, and share of its logarithm by which a drive jumps
CLEAR = 2.0  # times what is left, that a change of gain is
FINE, SURELY = 200.0, 0.97  # steps of a motion's sensor in its range; share with fewer of them
FEWEST = 80  # samples by which steps are compared
LATTICE = 0.05  # of a step, by which a reading may lie beside it
APART = 2e-3  # relative, by which two steps are different
OTHERS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # ratios of steps that only digits make, and their powers


def inspect(subject: Subject) -> Iterator[Finding]:
    """At most one finding for each drive."""
    done: set[str] = set()
    for law in laws(subject):
        if law.slips and pushes_away(law) and law.of not in done:
            yield _other_way_round(subject, law)
            return
        found = [
            each for each in breaks_of(law) if _is_one(law, each) and _is_seen(subject, law, each)
        ]
        if found and law.of not in done:
            best = max(found, key=lambda each: each.share)
            yield _ranged(subject, law, best) if best.kind == "range" else _slipped(
                subject, law, best)  # fmt: skip
            done.add(law.of)
    for name, expected in subject.expected.items():
        if expected.drives and name in subject.recording and name not in done:
            yield from _other_steps(subject, name)


def _other_way_round(subject: Subject, law: Relation) -> Finding:
    moved = subject.of(law.of).drives
    command = subject.of(moved).follows
    if command not in subject.recording:
        text = f"pushes {moved} away from the experiment's command: is its sign reversed?"
        return fault("sign", law.of, text, mend=mends.reversed_sign(subject, law.of))
    return other_way_round(subject, moved, command, f"is pushed away from {command} by {law.of}")


def _is_one(law: Relation, found: Break) -> bool:
    """Whether a law holds to either side, and a break of it is clear."""
    kind = found.kind if found.kind == "range" else f"slip of {law.name}"
    if found.before == 1.0 and found.left < FAR_LEFT and found.kind == "range":
        return True  # far, by either part alone
    if found.kind == "range" and not _jumps(law.drive, found):
        return False
    clear = found.kind != "range" or abs(np.log(max(found.size, 1e-6))) > CLEAR * found.left
    if kind == "slip of controller" and found.share > ALL and found.before > BROKEN:
        return found.left < HELD
    return found.share > SHARE[kind] and found.left < LEFT[kind] and clear


def _jumps(drive: FloatArray, found: Break) -> bool:
    """Whether a drive jumps where its range was switched, by what the factor says.

    A law that differs by direction, by load or by speed changes as fast as the machine does.
    """
    wanted = np.log(max(found.size, 1e-6))
    for place in range(max(found.place - NEAR, 3), min(found.place + NEAR, drive.size - 4) + 1):
        usual = (drive[place - 1] - drive[place - 3] + drive[place + 3] - drive[place + 1]) / 2.0
        before, after = drive[place - 1] + usual / 2.0, drive[place + 1] - usual / 2.0
        if before * after > 0.0 and np.log(after / before) / wanted > JUMPS:
            return True
    return False


def _is_seen(subject: Subject, law: Relation, found: Break) -> bool:
    """Whether a slip is more than what a coarse sensor hides of a slow motion, or a clipped one."""
    if found.kind == "slip" and law.of == "current" and _at_its_end(law, found):
        return False
    motion = subject.recording[subject.of(law.of).drives]
    coarse = found.kind == "slip" and law.slips and FINE * quantum(motion) > float(np.ptp(motion))
    return not coarse or found.share > SURELY


def _at_its_end(law: Relation, found: Break) -> bool:
    """Whether a sensed drive stands at an end of its range: clipped or limited.

    A sensor that clips has the law ask for less than the machine had, as a slip would. A duty has
    no sensor, and stands at its end in any steady motion.
    """
    there, reach = law.drive[found.place : found.end + 1], END * float(np.ptp(law.drive))
    ends = there > law.drive.max() - reach, there < law.drive.min() + reach
    return max(float(np.mean(each)) for each in ends) > MOSTLY


def _ranged(subject: Subject, law: Relation, found: Break) -> Finding:
    first = int(law.places[max(found.place - 1, 0)])
    return _switched(subject, law.of, first, f"{found.size:.3g} times what the {law.name} asks for")


def _switched(subject: Subject, name: str, first: int, what: str) -> Finding:
    return fault(
        "range",
        name,
        f"is {what} from about {subject.time[first]:.4g} s on: the range of its probe was "
        "switched, and its scale was not; leave out what follows, or what precedes (time.cut)",
        time=float(subject.time[first]),
        mend=mends.rest(subject, first),
    )


def _slipped(subject: Subject, law: Relation, found: Break) -> Finding:
    moved = subject.of(law.of).drives
    first = int(law.places[max(found.place - 1, 0)])
    last = int(law.places[min(found.end + 1, law.places.size - 1)])
    return fault(
        "slip",
        moved,
        f"turns {100.0 * abs(found.size) / (1.0 + abs(found.size)):.2g} % less than {law.of} says "
        f"from {subject.time[first]:.4g} to {subject.time[last]:.4g} s: the encoder slips on its "
        "shaft; fasten it, and leave out what follows (time.cut)",
        time=float(subject.time[first]),
        size=found.size,
        mend=mends.rest(subject, first),
    )


def _other_steps(subject: Subject, name: str) -> Iterator[Finding]:
    """Readings on one lattice of steps, and from some place on on another."""
    values = subject.recording[name]
    if values.size < FEWEST:
        return
    part = values.size // 4
    before, after = quantum(values[:part]), quantum(values[-part:])
    if not before or not after or abs(after / before - 1.0) < APART or _by_digits(after / before):
        return
    off = _beside(values, before)
    if not off.any():
        return
    first = int(np.argmax(off))
    if first < part or _beside(values[first:], after).any():
        return
    what = f"in steps of {subject.with_unit(after, name)}, before of "
    yield _switched(subject, name, first, f"{what}{subject.with_unit(before, name)},")


def _beside(values: FloatArray, step: float) -> NDArray[np.bool_]:
    counts = values / step
    return np.asarray(np.abs(counts - np.round(counts)) > LATTICE)


def _by_digits(ratio: float) -> bool:
    """Whether a ratio of steps is one that digits or a meter's ranges give."""
    lead = ratio / 10.0 ** np.floor(np.log10(ratio))
    return any(abs(lead / each - 1.0) < APART for each in OTHERS)
