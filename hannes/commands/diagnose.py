"""Find where simulation and recordings disagree, and which effect the model is missing.

A plant that says what of it is uncertain is diagnosed as identification/diagnosis tells. Others
take a lighter way, in this order: roles first; floor; base refitted; each effect refitted on the
same segments; the choice made on segments that no fit has seen; then all but the show recordings
refitted once more, and the show recordings opened.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.segments import Segment, in_roles, noise_floors, split_campaign
from hannes.campaigns.warnings import campaign_warnings
from hannes.core.by_value import ByValue
from hannes.core.effect import Effect
from hannes.core.io import atomic_files
from hannes.identification.diagnosis.campaign_diagnosis import (
    Result,
    declares_uncertainty,
    diagnose_campaign,
)
from hannes.identification.diagnosis.settings import Settings, read_settings
from hannes.identification.holdout import decision
from hannes.identification.holdout.effect_test import (
    ALPHA,
    Trial,
    judge,
    minimum_detectable_sizes,
    ranked,
    with_confusable,
)
from hannes.identification.holdout.least_squares import Fitted, Progress, WeightedResidual, fit
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
from hannes.plants.plant_file import base_name, plant_toml
from hannes.plants.protocol import Plant
from hannes.simulation.catalogue import effects

# Of the catalogue, on a hand with too few recordings for a claim: what to show beside "undecided".
HAND = base_name("hand")
TRIED = ("direction_friction", "gear_load", "leader_slack")


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(ByValue):
    """The verdict, the plant with what was found, and everything needed to draw it.

    details: of a plant that says what of it is uncertain, what the verdict came from.
    """

    campaign: Campaign = field(compare=False)
    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    noise_floors: dict[str, float]
    trials: tuple[Trial, ...] = field(compare=False)
    details: Result | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        found = ", ".join([self.verdict.verdict, *self.verdict.effects])
        return f"Diagnosis({found}; {len(self.campaign.entries)} recordings)"

    def write(self, folder: str | Path) -> Path:
        """Write verdict.json, hand.toml, report.html into `folder`, whole or not at all."""
        from hannes.report.diagnosis import page

        with atomic_files.atomic_folder(folder) as temporary:
            (temporary / "verdict.json").write_text(self.verdict.json(), encoding="utf-8")
            (temporary / "hand.toml").write_text(self.toml(), encoding="utf-8")
            (temporary / "report.html").write_text(page(self), encoding="utf-8")
        return Path(folder)

    def toml(self) -> str:
        """Text of the hand.toml of `plant`."""
        return plant_toml(self.plant, self.campaign.shipped, self.campaign.base)


def diagnose(
    campaign: Campaign | str | Path,
    *,
    out: str | Path | None = None,
    seed: int = 0,
    progress: bool | None = None,
) -> Diagnosis:
    """Diagnose a campaign, or the TOML file of one; writes to `out` where given.

    `progress`: a bar on standard error, by default where that is a terminal. Raises BadInput for
    what cannot be used, which is also what the data check calls a fault; ComputationFailed where a
    simulation fails.
    """
    if not isinstance(campaign, Campaign):
        campaign = read_campaign(campaign, seed)
    settings = read_settings(campaign.diagnose, campaign.plant)
    warnings = campaign_warnings(campaign)
    with _bar(progress) as report:
        if declares_uncertainty(campaign.plant) and not decision.lacking(
            campaign, split_campaign(campaign)[0], ()
        ):
            result = _by_fits(campaign, settings, seed, report)
        else:
            result = _Work(campaign, seed, report).result()
    warnings += result.verdict.cautions
    result = replace(result, verdict=replace(result.verdict, cautions=warnings))
    if out is not None:
        result.write(out)
    return result


def _by_fits(campaign: Campaign, settings: Settings, seed: int, report: Progress) -> Diagnosis:
    found = diagnose_campaign(campaign, settings, seed, report)
    return Diagnosis(
        campaign, found.verdict, found.plant, found.traces, found.noise_floors, (), found
    )


@contextmanager
def _bar(progress: bool | None) -> Iterator[Progress]:
    from tqdm import tqdm

    hidden = None if progress is None else not progress
    with tqdm(desc="diagnosing", unit=" steps", delay=2.0, disable=hidden, leave=False) as bar:

        def report(text: str) -> None:
            bar.set_description(f"fitting {text}", refresh=False)
            bar.update()

        yield report


class _Work:
    """One diagnosis in progress."""

    def __init__(self, campaign: Campaign, seed: int, progress: Progress) -> None:
        self.campaign, self.plant, self.seed, self.progress = (
            campaign,
            campaign.plant,
            seed,
            progress,
        )
        self.segments, self.note = split_campaign(campaign)
        self.known = self.of("fit", "select") or self.segments
        self.noise_floors, self.how = noise_floors(self.plant, self.known)

    def of(self, *roles: str) -> list[Segment]:
        return in_roles(self.segments, *roles)

    def residual(self, segments: Sequence[Segment]) -> WeightedResidual:
        return WeightedResidual(self.plant, segments, self.noise_floors)

    def result(self) -> Diagnosis:
        fitted = self.of("fit") or self.known
        base, scales = self.base(fitted)
        trials = self.trials(fitted, base, scales)
        best, said = self.choice(trials, base)
        known = WeightedResidual(self.plant, self.known, scales)
        before = fit(known, self.plant, base.values, self.progress)
        after = before
        if best is not None and best.fitted is not None:
            after = fit(known, best.fitted.plant, best.fitted.values, self.progress)
        return self.closed(said, best, trials, before, after)

    def base(self, fitted: Sequence[Segment]) -> tuple[Fitted, dict[str, float]]:
        """Refit the base, twice: first by the floor, then by what it leaves."""
        first = self.residual(fitted)
        rough = fit(first, self.plant, progress=self.progress)
        scales = inflated_noise_floors(self.noise_floors, first, rough)
        return fit(
            WeightedResidual(self.plant, fitted, scales), self.plant, rough.values, self.progress
        ), scales

    def trials(
        self, fitted: Sequence[Segment], base: Fitted, scales: Mapping[str, float]
    ) -> list[Trial]:
        chosen, rng = self.residual(self.of("select")), np.random.default_rng(self.seed)
        present, made = {each.name for each in self.plant.effects}, []
        for name, effect in self.candidates():
            if why := self.plant.accepts(effect):
                made.append(Trial(name, effect, f"not applicable: {why}"))
            elif effect.name in present:
                made.append(Trial(name, effect, "already in the model"))
            else:
                grown = self.plant.with_effects(effect)
                residual = WeightedResidual(self.plant, fitted, scales)
                trial = Trial(name, effect, fitted=fit(residual, grown, base.values, self.progress))
                made.append(
                    judge(trial, chosen, base, rng)
                    if chosen.segments
                    else replace(trial, why="no recording is left to choose by")
                )
        return ranked(with_confusable(made))

    def candidates(self) -> list[tuple[str, Effect]]:
        """The user's own effects, the plant's own, and those of the catalogue that are tried."""
        named = self.campaign.effects.items()
        if self.campaign.base != HAND:
            return list(named)
        return [(name, each) for name, each in named if name in TRIED or name not in effects()]

    def choice(
        self, trials: Sequence[Trial], base: Fitted
    ) -> tuple[Trial | None, decision.VerdictFields]:
        """Return the winner or None, and the verdict's first fields."""
        residual = self.residual(self.known)
        given, left = (
            times_noise_floor(residual, self.plant, values) for values in ({}, base.values)
        )
        lacking = decision.lacking(self.campaign, self.segments, trials)
        if lacking and not self.of("show"):
            lacking += f"; the gaps told are those on {self.shown()[1]}"
        return decision.decided(trials, given, left, lacking, self.note)

    def closed(
        self,
        said: decision.VerdictFields,
        best: Trial | None,
        trials: Sequence[Trial],
        before: Fitted,
        after: Fitted,
    ) -> Diagnosis:
        """Open the show recordings and put everything together."""
        shown, gap_on = self.shown()
        gap = gaps(self.residual(shown), before, after)
        said = decision.confirmed(said, gap)
        named = best is not None and bool(said["effects"])
        found = after if named else before
        result = Verdict(
            **said,
            parameters=_intervals(best, after) if best is not None and named else {},
            gap=gap if named else without_effect(gap),
            gap_on=gap_on,
            where=where(self.residual(self.known), before),
            candidates=[_candidate(trial) for trial in trials if trial.applicable],
            tried=[_attempt(trial) for trial in trials],
            alpha=ALPHA,
            recordings={role: [p.entry.name for p in self.of(role)] for role in
                        ("fit", "select", "show")},
            seed=self.seed,
            floor_from=self.how,
            cut=self.note,
            smallest_detectable=minimum_detectable_sizes(trials) or None,
        )  # fmt: skip
        usable = result.verdict not in ("undecided", "no_gap")
        plant = found.plant.with_values(found.values) if usable else self.plant
        drawn = tuple(
            traces(self.plant, entry, before, found, self.noise_floors)
            for entry in self.campaign.entries
        )
        return Diagnosis(self.campaign, result, plant, drawn, self.noise_floors, tuple(trials))

    def shown(self) -> tuple[list[Segment], str]:
        """The segments on which the gaps are told, and what they are."""
        shown = self.of("show")
        if not shown:
            return self.known, "the recordings that were fitted, for want of others"
        if not self.of("fit", "select"):
            return shown, "the recordings in role show, which were fitted too, for want of others"
        return shown, "the recordings in role show, which were never fitted"


def _intervals(best: Trial, after: Fitted) -> dict[str, dict]:
    """Value and 95 % interval of each of the effect's parameters, cut off at its bounds."""
    found = {}
    for each in best.effect.parameters:
        name = best.effect.full_name(each.name)
        value, reach = after.values[name], 1.96 * after.deviation(name)
        low, high = max(each.bounds[0], value - reach), min(each.bounds[1], value + reach)
        found[name] = {"value": value, "unit": each.unit, "low": low, "high": high}
        found[name]["off"] = each.off
    return found


def _candidate(trial: Trial) -> dict:
    return {
        "effect": trial.name,
        "evidence": trial.evidence,
        "gain_select": trial.share,
        "confusable_with": list(trial.confusable_with),
    }


def _attempt(trial: Trial) -> dict:
    return {
        "effect": trial.name,
        "applicable": trial.applicable,
        "accepted": trial.accepted,
        "why": trial.why or "accepted",
    }
