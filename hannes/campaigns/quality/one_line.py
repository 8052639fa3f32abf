"""One fault, one line: what follows from another finding is left out."""

from collections.abc import Sequence

from hannes.campaigns.quality.finding import Finding
from hannes.campaigns.quality.subject import Subject

MOTION = ("late-start", "unlike", "zero", "command", "pace")
VALUES = ("jump", "disabled", "unit", "sign", "magnitude", "saturated", "coarse", "frozen")
# Cause, whether only within its own channel and what that moves or follows, what it explains.
EXPLAINS: tuple[tuple[str, bool, tuple[str, ...]], ...] = (
    ("missing", True, (*VALUES, *MOTION)),
    ("signed", True, (*VALUES, *MOTION)),
    ("crosstalk", True, (*VALUES, *MOTION, "drift", "held")),
    ("swapped", False, ("sign", "disabled", "jump", "held", "drift", "coarse", "lost", *MOTION)),
    ("dead", True, ("magnitude", "disabled", "sign", "unit", "held", "coarse", *MOTION)),
    ("clock", False, ("drift", *MOTION)),
    ("held", False, ("saturated", "frozen", "jump", "lost", "pace")),
    ("frozen", True, ("saturated", "jump", "unlike", "drift", "sign", *MOTION)),
    ("lost", False, ("jump", "drift", "late-start", "unlike", "pace")),
    ("jump", True, (*VALUES, "drift", *MOTION)),
    ("unit", True, (*VALUES, "drift", *MOTION)),
    ("disabled", False, ("frozen", "saturated", "jump", "unlike", "drift", *MOTION)),
    ("unlike", True, ("sign", "drift", "frozen", "unit", *MOTION)),
    ("sign", True, ("sign", "disabled", "jump", "magnitude", "late-start", "zero", "command")),
    ("magnitude", True, ("sign", "coarse", "frozen", "disabled")),
    ("pace", True, ("late-start", "zero")),
    ("late-start", True, ("zero", "drift", "command")),
    ("drift", False, ("late-start", "zero", "pace")),
)  # fmt: skip
STANDS = ("frozen", "saturated", "held")  # what a drive that is off looks like, too
TIMING = ("unit", "clock")  # of the channel time: all that compares speeds follows


def one_line_each(found: Sequence[Finding], subject: Subject) -> list[Finding]:
    """Findings without those that another explains; notes stay."""
    kept: list[Finding] = []
    for each in _by_rank(found):
        same = any((k.kind, k.channel) == (each.kind, each.channel) for k in kept)
        same |= any(_is_same_stretch(k, each) for k in kept)
        if each.level == "note" or not (same or any(_explains(k, each, subject) for k in kept)):
            kept.append(each)
    if any(each.kind == "disabled" for each in kept):
        kept = [each for each in kept if each.kind not in STANDS]
    return [each for each in found if any(each is k for k in kept)]


def _is_same_stretch(one: Finding, other: Finding) -> bool:
    """Whether two channels stand for the same samples, which one line leaves out."""
    stands = one.kind == other.kind == "frozen"
    return stands and (one.level, one.time, one.size) == (other.level, other.time, other.size)


def _by_rank(found: Sequence[Finding]) -> list[Finding]:
    """Causes before what they explain."""
    order = [kind for kind, _, _ in EXPLAINS]
    rank = {kind: place for place, kind in enumerate(order)}
    return sorted(
        found,
        key=lambda each: (
            not (each.channel == "time" and each.kind in TIMING), rank.get(each.kind, len(rank))
        ),
    )  # fmt: skip


def _explains(cause: Finding, other: Finding, subject: Subject) -> bool:
    if cause.level == "note" or cause is other:
        return False
    if (cause.level, other.level) == ("warning", "fault") and cause.kind != "held":
        return False  # held frames alone make others leap; any other warning hides no fault
    if cause.channel == "time" and cause.kind in TIMING:
        return other.kind in (*MOTION, "drift", "sign", "jump", "gap", "unit", "held")
    near = {cause.channel, *_related(cause.channel, subject)}
    if cause.kind == other.kind:  # command and motion may both be in another unit
        near -= {subject.of(cause.channel).follows, *_followers(cause.channel, subject)}
    return any(
        kind == cause.kind and other.kind in explained and (not own or other.channel in near)
        for kind, own, explained in EXPLAINS
    )


def _followers(name: str, subject: Subject) -> set[str]:
    return {n for n, each in subject.expected.items() if each.follows == name}


def _related(name: str, subject: Subject) -> set[str]:
    """Channels whose findings compare them with this one."""
    expected = subject.expected.items()
    driving = {n for n, each in expected if name in (each.drives, each.follows)}
    return driving | {subject.of(name).follows} - {""}
