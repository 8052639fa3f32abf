"""What a decision must stand on recordings that were not fitted, simulated as the machine runs.

A fit moves a hundred parameters and compares bin means with quick simulations. What it leads to may
do otherwise under firmware's ticks, or between bins. So what was refitted or named is simulated
whole. It is withdrawn where it raises a gap, lowers none, or leaves too much anywhere. The misfit
weighs what runs differ by, which a gap does not. So an effect that leaves noise of a misfit may
lower no gap, where it lowers the misfit of runs in role `select`, without which it was fitted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.segments import Segment, in_roles
from hannes.identification.diagnosis.before_after import left
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.repeat_groups import Channels
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT
from hannes.identification.gap_change import (
    GapChange,
    gap_changes,
    hardly_tested,
    lacks_gain,
    refusal,
    refused_rise,
    too_faint,
)
from hannes.identification.remainder import SMALL, Remainder, largest, remainders
from hannes.identification.residuals import Raw
from hannes.plants.protocol import Plant

FAINT = (
    "what is named is too small to show in recordings that were not fitted: only the misfit of "
    "the fitted ones speaks for it"
)
NO_GAP_FALLS = (
    "on recordings that were not fitted no gap falls by more than runs differ by: the misfit of "
    "runs in role select, without which it was fitted, speaks for what is named"
)


@dataclass(frozen=True)
class Stages:
    """The machine as given, refitted, and with what was found: points and their simulations.

    runs: of each point, the channels of every segment;  failed: points that cannot be simulated
    remainder_floors, stated: by which what is left is judged: of channels, and of places
    """

    plant: Plant
    segments: Sequence[Segment]
    noise_floors: Mapping[str, float]
    remainder_floors: Mapping[str, float]
    points: tuple[Linearisation, ...]
    runs: tuple[Sequence[Channels], ...]
    failed: frozenset[int] = frozenset()
    stated: Raw = ()

    def raw(self, number: int, *roles: str) -> Raw:
        """Simulated minus recorded of every segment, or of those in some roles, at a stage."""
        pairs = zip(self.segments, self.runs[number], strict=True)
        some = [(segment, run) for segment, run in pairs if not roles or segment.role in roles]
        return left([s for s, _ in some], [run for _, run in some], list(self.noise_floors))

    def change(self, one: int, other: int) -> list[GapChange]:
        """How the gap of unfitted recordings changes between two stages."""
        unfitted = in_roles(self.segments, "show")
        before, after = self.raw(one, "show"), self.raw(other, "show")
        return gap_changes(self.plant, self.segments, unfitted, before, after, self.noise_floors)

    def remaining(self, one: int, other: int) -> list[Remainder]:
        """What is left in each place at one stage, beside another."""
        before, after = self.raw(one), self.raw(other)
        given = self.plant, self.segments, before, after, self.remainder_floors
        return remainders(*given, self.stated)

    def with_stage(self, number: int, other: int) -> "Stages":
        """The same with one stage in place of another."""
        points, runs = list(self.points), list(self.runs)
        points[number], runs[number] = points[other], runs[other]
        return replace(self, points=tuple(points), runs=tuple(runs))

    def refusal(self, one: int, other: int, shown: bool = False) -> str:
        """Why another stage is not taken after one, or an empty string.

        shown: whether runs in role select have shown a gain, so that no gap need fall
        """
        if other in self.failed:
            return "it cannot be simulated as the machine runs"
        changes = self.change(one, other)
        return refused_rise(changes) if shown else refusal(changes)


@dataclass(frozen=True)
class Guarded:
    """The decision that stands, the stages it is shown with, what a reader must know.

    refitted: whether the refitted baseline is taken
    """

    decision: Decision
    stages: Stages
    cautions: list[str]
    refitted: bool


def guarded(decision: Decision, stages: Stages) -> Guarded:
    """The decision, or what is left of it."""
    hardly, refitted = hardly_tested(stages.change(0, 1)), True
    cautions = [hardly] if hardly else []
    if why := stages.refusal(0, 1) or _not_compared(decision, stages):
        cautions.append(f"the refitted baseline is not taken: {why}")
        stages, refitted = stages.with_stage(1, 0), False
    if decision.effects:
        decision, more = _named(decision, stages)
        cautions += more
    elif decision.kind == "recalibrated":
        decision = _recalibrated(decision, stages, refitted)
    elif decision.kind == "no_gap":
        decision = _as_given(decision, stages, refitted)
    if decision.kind == "unknown" and refitted and (why := implausible(stages.points[1])):
        cautions.append(f"the refitted baseline is not taken: {why}")
        stages, refitted = stages.with_stage(1, 0), False
    if not decision.effects:
        stages = stages.with_stage(2, 0 if decision.kind == "no_gap" else 1)
        decision = replace(decision, point=stages.points[2])
    return Guarded(decision, stages, cautions, refitted)


def _not_compared(decision: Decision, stages: Stages) -> str:
    """Why a name is compared with the machine as given, not the refitted one, or an empty string.

    A machine that nobody has may do what is named. A name with a remainder must do more than that:
    what else is missing may be what both follow.
    """
    if decision.kind not in ("named", "one_of") or 2 in stages.failed or _shown(decision):
        return ""
    changes = stages.change(1, 2)
    lowers_none = lacks_gain(changes) and not refused_rise(changes)
    return implausible(stages.points[1]) if lowers_none else ""


def implausible(baseline: Linearisation) -> str:
    """Why a refitted baseline is no machine that there is, or an empty string."""
    place = int(np.argmax(np.abs(baseline.x)))
    if (far := abs(float(baseline.x[place]))) <= SEARCH.far_away:
        return ""
    name = baseline.space.parameters[place].name
    return f"it takes {name} {far:.0f} times as far from its given value as scatter allows"


def _named(decision: Decision, stages: Stages) -> tuple[Decision, list[str]]:
    """The same, or unknown; and a caution where unfitted recordings can say nothing."""
    if why := stages.refusal(1, 2, _shown(decision)):
        return _unknown(decision, stages, why), []
    rest = stages.remaining(1, 2)
    if worst := largest(rest):
        return _unknown(decision, stages, f"it leaves {worst.text}"), []
    if decision.kind == "named_with_remainder" and rest:
        decision = replace(decision, reason=f"{decision.reason}; most is left as {rest[0].text}")
    changes = stages.change(1, 2)
    if refusal(changes):
        return decision, [NO_GAP_FALLS]
    return decision, [FAINT] if too_faint(changes) else []


def _shown(decision: Decision) -> bool:
    """Whether runs in role select show what is named, and it leaves noise alone."""
    if decision.held_out <= VERDICT.heldout_shown:
        return False
    return decision.point.chi2 <= VERDICT.clean * decision.point.residual.size


def _recalibrated(decision: Decision, stages: Stages, refitted: bool) -> Decision:
    """The same, no gap where refitting only worsens, or unknown where much is left."""
    rest = stages.remaining(0, 1)
    if refitted:
        worst = largest(rest)
        return _unknown(decision, stages, f"it leaves {worst.text}") if worst else decision
    if rest and rest[0].after > SMALL:
        return _unknown(decision, stages, f"as given it leaves {rest[0].text}")
    reason = f"as given it leaves no more than {SMALL:g} times the noise floor anywhere"
    return Decision("no_gap", (), reason, stages.points[0])


def _as_given(decision: Decision, stages: Stages, refitted: bool) -> Decision:
    """No gap; recalibrated, or unknown, where the machine as given leaves much anywhere."""
    worst = largest(stages.remaining(0, 0))
    if worst is None:
        sound = (
            refitted and not largest(stages.remaining(0, 1)) and not implausible(stages.points[1])
        )
        closed = _closed(stages) if sound else ""
        more = (
            f"{decision.reason}; refitted values lower the gap of recordings not fitted, {closed}"
        )
        return Decision("recalibrated", (), more, stages.points[1]) if closed else decision
    left = f"as given it leaves {worst.text}"
    if refitted and not largest(stages.remaining(0, 1)):
        reason = f"{decision.reason}, but {left}; the refitted machine leaves little anywhere"
        return Decision("recalibrated", (), reason, stages.points[1])
    return _unknown(decision, stages, left)


def _closed(stages: Stages) -> str:
    """A gap of unfitted recordings that a refit more than halves, in words, or an empty string.

    Machines may differ so far; a simulation that is off by more than runs differ is still mended.
    """
    return next(
        (
            each.text
            for each in stages.change(0, 1)
            if each.better
            and each.before > SMALL * stages.noise_floors[each.channel]
            and each.after < 0.5 * each.before
        ),
        "",
    )


def _unknown(decision: Decision, stages: Stages, why: str) -> Decision:
    return Decision("unknown", (), f"{decision.reason}, but {why}", stages.points[1])
