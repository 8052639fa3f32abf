"""The diagnosis of a plant that declares nothing uncertain: every effect judged by hold-out.

In this order: noise floor; baseline fit; each effect refitted on the same segments; the choice made
on validation segments; then everything but the test recordings refitted once more, and the test
recordings opened.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.segments import Segment, in_roles, noise_floors, split_campaign
from hannes.core.effect import Effect
from hannes.identification.baseline_table import Refitted, baseline_table
from hannes.identification.gap_change import GapChange, gap_changes, refusal
from hannes.identification.holdout import decision
from hannes.identification.holdout.effect_test import (
    Trial,
    minimum_detectable_sizes,
    ranked,
    tried,
    with_confusable,
)
from hannes.identification.holdout.least_squares import Fitted, Progress, WeightedResidual, fit
from hannes.identification.holdout.starting_points import start
from hannes.identification.holdout.tuning import HOLDOUT
from hannes.identification.holdout.work_bound import most_simulations
from hannes.identification.pattern.goes_with import by_stage
from hannes.identification.remainder import Remainder, largest, remainders
from hannes.identification.residuals import (
    Traces,
    gaps,
    inflated_noise_floors,
    times_noise_floor,
    traces,
    where,
    without_effect,
)
from hannes.identification.verdict import Verdict
from hannes.plants.plant_file import base_name
from hannes.plants.protocol import Plant
from hannes.simulation.catalogue import effects

# Of the catalogue, on a hand with too few recordings for a claim: shown beside "undecided".
HAND = base_name("hand")
TRIED = ("direction_friction", "gear_load", "leader_slack")
INTERVALS_FROM = (
    "the Gauss-Newton Hessian with priors at the refitted baseline, or how its residual scatters "
    "from block to block, whichever is wider"
)
NORMAL = 1.96  # standard deviations on each side of a normal 95 % interval


@dataclass(frozen=True)
class HoldoutResult:
    """The verdict, the plant with what was found, and what its page draws.

    traces: of every recording;  noise_floors: channel -> its unit;  trials: best first
    """

    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    noise_floors: dict[str, float]
    trials: tuple[Trial, ...]


def diagnose_by_holdout(campaign: Campaign, seed: int, progress: Progress) -> HoldoutResult:
    """Diagnose a campaign; `progress` is called with what is fitted next.

    Raises ComputationFailed where a simulation fails.
    """
    return _HoldoutDiagnosis(campaign, seed, progress).result()


class _HoldoutDiagnosis:
    """One diagnosis in progress."""

    def __init__(self, campaign: Campaign, seed: int, progress: Progress) -> None:
        self.campaign, self.plant = campaign, campaign.plant
        self.seed, self.progress = seed, progress
        self.segments, self.note = split_campaign(campaign)
        self.known = self.of("fit", "select") or self.segments
        self.noise_floors, self.how = noise_floors(self.plant, self.known)

    def of(self, *roles: str) -> list[Segment]:
        return in_roles(self.segments, *roles)

    def residual(self, segments: Sequence[Segment]) -> WeightedResidual:
        return WeightedResidual(self.plant, segments, self.noise_floors)

    def result(self) -> HoldoutResult:
        tried = [effect for _, effect in self.candidates() if not self.plant.accepts(effect)]
        most = most_simulations(self.plant, self.segments, tried)
        self.progress(f"at most {most:,} simulations")
        training = self.of("fit") or self.known
        baseline, scales = self.baseline(training)
        trials = self.trials(training, baseline, scales)
        best, fields = self.choice(trials, baseline)
        known = WeightedResidual(self.plant, self.known, scales)
        before = fit(known, self.plant, baseline.values, self.progress)
        after = before
        if best is not None and best.fitted is not None:
            after = fit(known, best.fitted.plant, best.fitted.values, self.progress)
        return self.closed(fields, best, trials, before, after)

    def baseline(self, training: Sequence[Segment]) -> tuple[Fitted, dict[str, float]]:
        """The baseline fit, twice: first weighted by the noise floor, then by its residual."""
        first = self.residual(training)
        begun = start(first, self.plant, self.progress)
        rough = fit(first, self.plant, begun, self.progress)
        scales = inflated_noise_floors(self.noise_floors, first, rough)
        residual = WeightedResidual(self.plant, training, scales)
        return fit(residual, self.plant, rough.values, self.progress), scales

    def trials(
        self, training: Sequence[Segment], baseline: Fitted, scales: Mapping[str, float]
    ) -> list[Trial]:
        validation, rng = self.residual(self.of("select")), np.random.default_rng(self.seed)
        residual = WeightedResidual(self.plant, training, scales)
        present, made = {each.name for each in self.plant.effects}, []
        for name, effect in self.candidates():
            if why := self.plant.accepts(effect):
                made.append(Trial(name, effect, f"not applicable: {why}"))
            elif effect.name in present:
                made.append(Trial(name, effect, "already in the model"))
            else:
                made.append(tried(name, effect, residual, baseline, validation, rng, self.progress))
        return ranked(with_confusable(made))

    def candidates(self) -> list[tuple[str, Effect]]:
        """The user's own effects, the plant's own, and those of the catalogue that are tried."""
        named = self.campaign.effects.items()
        if self.campaign.base != HAND:
            return list(named)
        return [(name, each) for name, each in named if name in TRIED or name not in effects()]

    def choice(
        self, trials: Sequence[Trial], baseline: Fitted
    ) -> tuple[Trial | None, decision.VerdictFields]:
        """Return the winner or None, and the verdict's first fields."""
        residual = self.residual(self.known)
        nominal, left = (
            times_noise_floor(residual, self.plant, values) for values in ({}, baseline.values)
        )
        lacking = decision.lacking(self.campaign, self.segments, trials)
        if lacking and not self.of("show"):
            lacking += f"; the gaps shown are those on {self.test()[1]}"
        return decision.decided(trials, nominal, left, lacking, self.note)

    def closed(
        self,
        fields: decision.VerdictFields,
        best: Trial | None,
        trials: Sequence[Trial],
        before: Fitted,
        after: Fitted,
    ) -> HoldoutResult:
        """Open the test recordings and assemble the verdict."""
        test, gap_on = self.test()
        before, caution = self.taken(test, before)
        after = before if best is None else after
        gap = gaps(self.residual(test), before, after)
        fields = decision.without_refit(fields, caution)
        fields = decision.small_everywhere(fields, self.largest_left(fields, before))
        fields = decision.confirmed(fields, gap, refusal(self.change(test, before, after)))
        named = best is not None and bool(fields["effects"])
        found = after if named else before
        verdict = Verdict(
            **fields,
            parameters=_intervals(best, after) if best is not None and named else {},
            gap=gap if named else without_effect(gap),
            gap_on=gap_on,
            where=where(self.residual(self.known), before),
            candidates=[_candidate(trial) for trial in trials if trial.applicable],
            tried=[_attempt(trial) for trial in trials],
            alpha=HOLDOUT.false_alarms,
            recordings={
                role: [each.entry.name for each in self.of(role)]
                for role in ("fit", "select", "show")
            },
            seed=self.seed,
            floor_from=self.how,
            cut=self.note,
            smallest_detectable=minimum_detectable_sizes(trials) or None,
            baseline=None if caution else _baseline(before),
            cautions=[caution] if caution else [],
            goes_with=self.goes_with(fields["verdict"], before, *([after] if named else [])),
        )
        usable = verdict.verdict not in ("undecided", "no_gap")
        plant = found.plant.with_values(found.values) if usable else self.plant
        drawn = tuple(
            traces(self.plant, entry, before, found, self.noise_floors)
            for entry in self.campaign.entries
        )
        return HoldoutResult(verdict, plant, drawn, self.noise_floors, tuple(trials))

    def taken(self, test: Sequence[Segment], before: Fitted) -> tuple[Fitted, str]:
        """The refitted baseline, or as given where unfitted recordings oppose it; and why."""
        given = self.as_given(before)
        why = refusal(self.change(test, given, before)) if self.of("show") else ""
        return (given, f"the refitted baseline is not taken: {why}") if why else (before, "")

    def largest_left(self, fields: decision.VerdictFields, before: Fitted) -> Remainder | None:
        """Where a verdict of absence leaves more than little, or None."""
        if fields["verdict"] not in ("no_gap", "recalibrated"):
            return None
        given = self.as_given(before)
        taken = given if fields["verdict"] == "no_gap" else before
        residual = self.residual(self.segments)
        was, now = (residual.raw(each.plant, each.values) for each in (given, taken))
        return largest(remainders(self.plant, self.segments, was, now, self.noise_floors))

    def as_given(self, fitted: Fitted) -> Fitted:
        """The same fit with every parameter at its given value."""
        return replace(fitted, values={name: self.plant.parameters[name] for name in fitted.names})

    def change(self, test: Sequence[Segment], before: Fitted, after: Fitted) -> list[GapChange]:
        """How the gap of recordings that were not fitted changes between two fits."""
        residual = self.residual(test)
        old, new = (residual.raw(each.plant, each.values) for each in (before, after))
        return gap_changes(self.plant, self.segments, test, old, new, self.noise_floors)

    def goes_with(self, verdict: str, *fits: Fitted) -> dict[str, Any]:
        """What the refitted baseline, and the result, leave of the fitted recordings."""
        raw, names = self.residual(self.known).raw, ("baseline", "left")[: len(fits)]
        stages = {n: partial(raw, f.plant, f.values) for n, f in zip(names, fits, strict=True)}
        some = {} if verdict == "no_gap" else stages
        return by_stage(self.plant, self.known, self.noise_floors, some)

    def test(self) -> tuple[list[Segment], str]:
        """The segments on which the gaps are measured, and what they are."""
        test = self.of("show")
        if not test:
            return self.known, "the recordings that were fitted, for want of others"
        if not self.of("fit", "select"):
            return test, "the recordings in role show, which were fitted too, for want of others"
        return test, "the recordings in role show, which were never fitted"


def _baseline(before: Fitted) -> dict[str, Any]:
    """What of the machine itself was off, by the baseline fit."""
    declared = before.plant.parameters.declared
    found = [
        Refitted(
            name,
            declared[name].unit,
            before.plant.parameters[name],
            before.values[name],
            before.deviation(name),
            float(scale / weight),
            declared[name].bounds,
        )
        for name, scale, weight in zip(before.names, before.scales, before.prior, strict=True)
    ]
    return baseline_table(found, INTERVALS_FROM)


def _intervals(best: Trial, after: Fitted) -> dict[str, dict[str, Any]]:
    """Value and 95 % interval of each of the effect's parameters, cut off at its bounds."""
    found = {}
    for each in best.effect.fitted:
        name = best.effect.full_name(each.name)
        value, reach = after.values[name], NORMAL * after.deviation(name)
        low, high = max(each.bounds[0], value - reach), min(each.bounds[1], value + reach)
        found[name] = {"value": value, "unit": each.unit, "low": low, "high": high}
        found[name]["off"] = each.off
    return found


def _candidate(trial: Trial) -> dict[str, Any]:
    return {
        "effect": trial.name,
        "evidence": trial.evidence,
        "gain_select": trial.share,
        "confusable_with": list(trial.confusable_with),
    }


def _attempt(trial: Trial) -> dict[str, Any]:
    return {
        "effect": trial.name,
        "applicable": trial.applicable,
        "accepted": trial.accepted,
        "why": trial.why or "accepted",
    }
