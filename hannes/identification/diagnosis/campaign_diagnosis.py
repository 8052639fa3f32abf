"""The diagnosis of a campaign by fits: from its recordings to the verdict and its page."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.segments import Segment, in_roles, noise_floors, split_campaign
from hannes.core.effect import Effect
from hannes.identification.diagnosis.baseline_intervals import refitted_baseline
from hannes.identification.diagnosis.before_after import STAGES, simulated, traced
from hannes.identification.diagnosis.decision import Decision, decide
from hannes.identification.diagnosis.each_explains import each_explains
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.effect_sizes import interval, may_be_zero, with_sizes
from hannes.identification.diagnosis.evidence_tables import EvidenceTables
from hannes.identification.diagnosis.experiment_design import next_run
from hannes.identification.diagnosis.fitted_deviations import with_deviations
from hannes.identification.diagnosis.foretold import foretold
from hannes.identification.diagnosis.generic_disturbances import EFFECTS as GENERIC
from hannes.identification.diagnosis.heldout import runs_in_role
from hannes.identification.diagnosis.hold_out_guard import Stages, guarded
from hannes.identification.diagnosis.nearest import nearest
from hannes.identification.diagnosis.observed_controller import as_recorded
from hannes.identification.diagnosis.probability import tabled_probabilities
from hannes.identification.diagnosis.remainder_floors import remainder_floors, stated_spread
from hannes.identification.diagnosis.repeat_groups import Channels
from hannes.identification.diagnosis.run_to_run import disagreement
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.shape.shape import Shape, shape_of
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import VERDICT
from hannes.identification.diagnosis.untested import untested
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.identification.pattern.goes_with import by_stage
from hannes.identification.residuals import Traces, located, tabled
from hannes.identification.verdict import Verdict
from hannes.plants.part_fault import compiled_effects
from hannes.plants.protocol import Plant

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Result:
    """The verdict, the plant with what was found, and what the page draws.

    traces: of the held-out recordings;  noise_floors: channel -> its unit
    found, decision, stages: what the verdict follows from;  shape: of an unknown
    """

    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    noise_floors: dict[str, float]
    found: SearchResult
    decision: Decision
    stages: Stages
    shape: Shape | None = None


def declares_uncertainty(plant: Plant) -> bool:
    """Whether a plant declares what of it is uncertain, which this diagnosis needs."""
    return bool(uncertain(plant))


def uncertain(plant: Plant) -> Mapping[str, float]:
    """What a plant declares uncertain; empty where it says nothing of that."""
    found: Mapping[str, float] = getattr(plant, "uncertain", {})
    return found


def diagnose_campaign(
    campaign: Campaign, settings: Settings, seed: int, progress: Progress
) -> Result:
    """Diagnose a campaign in which every role is filled.

    Raises ComputationFailed where the baseline cannot be simulated.
    """
    import scipy.linalg  # noqa: F401  loaded now, or its threads are not limited
    from threadpoolctl import threadpool_limits

    tried = candidates(campaign)
    usable = [each for each, why in tried.values() if not why]
    usable += [each for each in GENERIC if not campaign.plant.accepts(each)]
    work = Work(bounded=True, times=settings.work)
    progress(foretold(campaign, work, len(uncertain(campaign.plant))))
    with threadpool_limits(1, "blas"):  # sums over several threads round otherwise
        campaign, observed = as_recorded(campaign, settings, seed, progress, work)
        known = campaign.of("fit", "select")
        found = search_effects(campaign.plant, known, usable, settings, seed, progress, work)
        decision, spread = _decided(found, seed, progress)
        progress("the test recordings")
        closing = _Closing(campaign, found, decision, spread, seed)
        result = closing.result(tried, progress)
    cautions = [observed] if observed else []
    cautions += disagreement(settings, closing.model.space.settings)
    cautions += result.verdict.cautions
    return replace(result, verdict=replace(result.verdict, cautions=cautions))


def _decided(
    found: SearchResult, seed: int, progress: Progress
) -> tuple[Decision, dict[int, float]]:
    """The decision and how certain its sizes are; unknown where the search was ended."""
    work = found.baseline.model.work
    try:
        if found.ended:
            raise SearchEnded
        work.extended()
        groups = found.baseline.model.groups
        decision = decide(found, *(runs_in_role(groups, role) for role in ("fit", "select")))
        settled, spread = with_sizes(decision, seed, found.variance_factor, progress)
        if not may_be_zero(settled, spread, found.variance_factor):
            return settled, spread
        reason = f"{settled.reason}, but its size may be zero"
        return Decision("unknown", (), reason, found.baseline), {}
    except SearchEnded:
        return Decision("unknown", (), work.ended, found.baseline), {}


def candidates(campaign: Campaign) -> dict[str, tuple[Effect, str]]:
    """Name by which an effect can be found -> the effect, and why it cannot be tried or ""."""
    present = {each.name for each in campaign.plant.effects}
    return {
        name: (
            effect,
            "already in the model" if effect.name in present else _unfit(campaign.plant, effect),
        )
        for name, effect in campaign.effects.items()
    }


def _unfit(plant: Plant, effect: Effect) -> str:
    why = plant.accepts(effect)
    return f"not applicable: {why}" if why else ""


class _Closing:
    """Opens the held-out recordings and assembles the verdict."""

    def __init__(
        self,
        campaign: Campaign,
        found: SearchResult,
        decision: Decision,
        spread: Mapping[int, float],
        seed: int,
    ) -> None:
        self.campaign, self.found, self.decision, self.seed = campaign, found, decision, seed
        self.spread = spread  # standard deviation of each fitted parameter, by index
        segments, _ = split_campaign(campaign)
        self.known, self.heldout = (in_roles(segments, *r) for r in (("fit", "select"), ("show",)))
        self.segments = [*self.known, *self.heldout]
        self.noise_floors, self.how = noise_floors(campaign.plant, self.known)
        self.model = found.baseline.model
        self.names = {each.name: name for name, each in campaign.effects.items()}

    def result(self, tried: dict[str, tuple[Effect, str]], progress: Progress) -> Result:
        plant, stood = self.campaign.plant, guarded(self.decision, self.stages())
        self.decision = decision = stood.decision
        self.spread = self.spread if decision.effects else {}
        stages = stood.stages
        raws = {key: stages.raw(k, "show") for k, key in enumerate(STAGES)}
        tables = EvidenceTables(self.found, self.names)
        shape = None
        if decision.kind == "unknown":
            shape = shape_of(self.found, stages, self.owner(), progress)
        verdict = Verdict(
            verdict=decision.kind,
            effects=[self.names[name] for name in decision.effects],
            parameters=self.parameters(),
            gap=tabled(raws, self.heldout, plant.channels, self.noise_floors),
            where=located(plant, self.known, stages.raw(1, "fit", "select"), self.noise_floors),
            candidates=tables.candidates(),
            reason=decision.reason,
            tried=tables.tried(tried, decision.effects),
            alpha=VERDICT.false_alarms,
            recordings={
                role: [entry.name for entry in self.campaign.of(role)]
                for role in ("fit", "select", "show")
            },
            seed=self.seed,
            gap_on="the recordings in role show, which were never fitted",
            floor_from=self.how,
            next_run=self.next_run(),
            smallest_detectable=tables.detectable(),
            confusability=tables.confusability(),
            baseline=refitted_baseline(self.found.baseline, self.found.variance_factor)
            if stood.refitted
            else None,
            cautions=stood.cautions + untested(self.found, decision.kind),
            nearest=nearest(self.found, decision, self.names),
            goes_with=self.goes_with(stages),
            shape=shape.table if shape else {},
            probabilities=tabled_probabilities(self.found, decision, self.names),
            each_explains=each_explains(stages, decision, self.found.variance_factor, self.names),
        )
        traces = tuple(
            traced(segment, [each[k] for each in stages.runs], list(self.noise_floors))
            for k, segment in enumerate(self.segments)
            if segment.role == "show"
        )
        found = self.noise_floors, self.found, decision, stages, shape
        return Result(verdict, self.refitted(), traces, *found)

    def stages(self) -> Stages:
        """The machine as given, refitted, and with what was found, simulated whole."""
        points = (self.found.nominal, self.found.baseline, self.decision.point)
        places = np.array([each.x for each in points])
        with self.model.work.in_any_case():
            made = with_deviations(
                simulated(self.model, _entries(self.segments), places, as_given=1),
                _entries(self.segments),
                points[1:],
                self.found.variance_factor,
            )
        failed = {k for k in range(len(points)) if any(each[k] is None for each in made)}
        runs: list[list[Channels]] = []
        for k in range(len(points)):
            there = [each[k] for each in made]
            runs.append([each for each in there if each] if k not in failed else runs[-1])
        noise = self.found.baseline.noise
        both = self.noise_floors, remainder_floors(self.noise_floors, noise)
        given = self.campaign.plant, self.segments, *both, points, tuple(runs)
        return Stages(*given, frozenset(failed), stated_spread(noise, self.segments))

    def goes_with(self, stages: Stages) -> dict[str, Any]:
        """What the refitted baseline, and the result, leave of the fitted recordings."""
        some = {} if self.decision.kind == "no_gap" else {"baseline": 1}
        some |= {"left": 2} if self.decision.effects else {}
        raws = {key: partial(stages.raw, k, "fit", "select") for key, k in some.items()}
        return by_stage(stages.plant, self.known, self.noise_floors, raws)

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Value and 95 % interval of each parameter of the named effects, within its bounds."""
        decision, found = self.decision, {}
        if not decision.effects:
            return {}
        space = self.model.space
        for place in map(int, space.of(*decision.effects)):
            if place not in self.spread:
                continue  # only the first effect of a class is fitted
            name = space.parameters[place].name
            declared = space.declared(name)
            found[name] = {
                **interval(decision.point, place, self.spread[place], self.found.variance_factor),
                "unit": declared.unit,
                "off": declared.off,
            }
        return found

    def next_run(self) -> dict[str, Any] | None:
        """The run worth recording where effects compete or none is named."""
        kind, trials = self.decision.kind, self.found.trials
        if kind not in ("one_of", "unknown") or not trials:
            return None
        known = _entries(self.known)
        try:
            return next_run(self.campaign.plant, self.found, known, self.names)
        except SearchEnded:
            return None

    def refitted(self) -> Plant:
        """The plant as given, refitted, or refitted with the effects found."""
        plant, decision = self.campaign.plant, self.decision
        if decision.kind == "no_gap":
            return plant
        space = self.model.space
        named = [
            e for n, e in space.effects.items() if self.spread.keys() & set(space.of(n).tolist())
        ]
        values = space.values(decision.point.x, self.owner())
        values |= space.after_all([each.entry for each in self.segments])
        extended = plant.with_effects(*compiled_effects(tuple(named)))
        return extended.with_values({n: v for n, v in values.items() if n in extended.parameters})

    def owner(self) -> str:
        """Whose own parameters a hand.toml takes: those of the object that the plant has itself."""
        for group in self.model.groups:
            same = all(group.nominal[n] == self.campaign.plant.parameters[n] for n in group.own)
            if group.own and same:
                return group.owner
        return ""


def _entries(segments: list[Segment]) -> list[Entry]:
    return [segment.entry for segment in segments]
