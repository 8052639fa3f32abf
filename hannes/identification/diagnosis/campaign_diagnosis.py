"""The deep diagnosis of a campaign: from its recordings to the verdict and what draws it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.campaigns.segments import Segment, in_roles, noise_floors, split_campaign
from hannes.core.effect import Effect
from hannes.identification.diagnosis.before_after import STAGES, left, simulated, traced
from hannes.identification.diagnosis.decision import Choice, chosen
from hannes.identification.diagnosis.effect_search import LIMIT, PRICE, Found, investigate
from hannes.identification.diagnosis.effect_sizes import interval, with_sizes
from hannes.identification.diagnosis.experiment_design import next_run
from hannes.identification.diagnosis.generic_disturbances import EFFECTS as NAMELESS
from hannes.identification.diagnosis.run_to_run import disagreement
from hannes.identification.diagnosis.score_test import amplitude_names, likeness, projected
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.residuals import Traces, placed, tabled
from hannes.identification.verdict import Verdict
from hannes.plants.protocol import Plant

ALPHA = 0.02  # of empty hands on which LIMIT aims to name something, at most
COMPARED = 8  # effects of which the confusability is told
POWER_80 = 0.842  # standard deviations above a limit that are seen four times in five
Told = Callable[[str], None]


@dataclass(frozen=True)
class Result:
    """The verdict, the plant with what was found, traces of the recordings shown, floors.

    found, choice: what it all came from.
    """

    verdict: Verdict
    plant: Plant
    traces: tuple[Traces, ...]
    floors: dict[str, float]
    found: Found
    choice: Choice


def possible(plant: Plant) -> bool:
    """Tell whether a plant says all that a deep diagnosis asks: what of it is uncertain."""
    return bool(getattr(plant, "uncertain", {}))


def deep(campaign: Campaign, settings: Settings, seed: int, told: Told) -> Result:
    """Diagnose a campaign that lacks no role. ComputationFailed where its base cannot be run."""
    import scipy.linalg  # noqa: F401  loaded now, or its threads are not limited
    from threadpoolctl import threadpool_limits

    known = campaign.of("fit", "select")
    tried = candidates(campaign)
    usable = [each for each, why in tried.values() if not why]
    usable += [each for each in NAMELESS if not campaign.plant.accepts(each)]
    with threadpool_limits(1, "blas"):  # sums of many threads end on other bits
        found = investigate(campaign.plant, known, usable, settings, seed, told)
        choice = chosen(found, *(_masks(found, role) for role in ("fit", "select")))
        choice, spread = with_sizes(choice, seed, found.unit, told)
        told("the recordings to show")
        closing = _Closing(campaign, found, choice, spread, seed)
        result = closing.result(tried)
    said = disagreement(settings, closing.model.space.settings)
    return replace(result, verdict=replace(result.verdict, cautions=said))


def candidates(campaign: Campaign) -> dict[str, tuple[Effect, str]]:
    """Name by which each effect can be found again -> effect, why it cannot be tried or ''."""
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


def _masks(found: Found, role: str) -> list[int]:
    """Bit mask of the runs of each group that have a role."""
    return [
        sum(1 << k for k, entry in enumerate(group.entries) if entry.role == role)
        for group in found.base.ground.model.groups
    ]


class _Closing:
    """Opens the show recordings and puts everything together."""

    def __init__(
        self,
        campaign: Campaign,
        found: Found,
        choice: Choice,
        spread: Mapping[int, float],
        seed: int,
    ) -> None:
        self.campaign, self.found, self.choice, self.seed = campaign, found, choice, seed
        self.spread = spread  # standard deviation of each direction that was fitted, by place
        pieces, _ = split_campaign(campaign)
        self.known, self.shown = (in_roles(pieces, *r) for r in (("fit", "select"), ("show",)))
        self.floors, self.how = noise_floors(campaign.plant, self.known)
        self.model = found.base.ground.model
        self.names = {each.name: name for name, each in campaign.effects.items()}

    def result(self, tried: dict[str, tuple[Effect, str]]) -> Result:
        choice, plant = self.choice, self.campaign.plant
        places = np.array([each.x for each in (self.found.given, self.found.base, choice.point)])
        runs = simulated(self.model, _entries(self.shown), places)
        stages = {key: [each[k] for each in runs] for k, key in enumerate(STAGES)}
        raws = {key: left(self.shown, each, list(self.floors)) for key, each in stages.items()}
        base = simulated(self.model, _entries(self.known), places[1:2])
        kept = left(self.known, [each[0] for each in base], list(self.floors))
        verdict = Verdict(
            verdict=choice.kind,
            effects=[self.names[name] for name in choice.effects],
            parameters=self.parameters(),
            gap=tabled(raws, self.shown, plant.channels, self.floors),
            where=placed(plant, self.known, kept, self.floors),
            candidates=self.candidates(),
            reason=choice.reason,
            tried=self.tried(tried),
            alpha=ALPHA,
            recordings={
                role: [entry.name for entry in self.campaign.of(role)]
                for role in ("fit", "select", "show")
            },
            seed=self.seed,
            gap_on="the recordings in role show, which were never fitted",
            floor_from=self.how,
            next_run=self.next_run(),
            smallest_detectable=self.detectable(),
            confusability=self.confusability(),
        )
        traces = tuple(
            traced(piece, each, list(self.floors))
            for piece, each in zip(self.shown, runs, strict=True)
        )
        return Result(verdict, self.refitted(), traces, self.floors, self.found, choice)

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Value and 95 % interval of each parameter of the effects named, within its bounds."""
        choice, found = self.choice, {}
        if not choice.effects:
            return {}
        space = self.model.space
        for place in map(int, space.of(*choice.effects)):
            if place not in self.spread:
                continue  # of a class only the first is fitted
            name = space.directions[place].name
            declared = self.model.whole.parameters.declared[name]
            found[name] = {
                **interval(choice.point, place, self.spread[place], self.found.unit),
                "unit": declared.unit,
                "off": declared.off,
            }
        return found

    def candidates(self) -> list[dict[str, Any]]:
        """Every effect that was looked at, best first; gains of those refitted are exact."""
        exact = {trial.effects[0]: trial for trial in self.found.trials}
        rows = []
        for guess in self.found.guesses:
            trial = exact.get(guess.effect)
            gain = trial.gain if trial else guess.gain / self.found.unit
            rows.append(
                {
                    "effect": self.names[guess.effect],
                    "evidence": float(np.sqrt(max(0.0, gain))),
                    "gain_select": self.share(gain),
                    "refitted": trial is not None,
                    "confusable_with": [self.names[name] for name in trial.alike] if trial else [],
                }
            )
        return sorted(rows, key=lambda row: -row["evidence"])

    def share(self, gain: float) -> float:
        """Gain as a share of all that was found to go, or that lies above what is expected."""
        trials = [*self.found.trials, *([self.found.pair] if self.found.pair else [])]
        most = max([trial.gain for trial in trials], default=0.0)
        above = (self.found.base.misfit - self.found.bins) / self.found.unit
        return max(0.0, float(gain / max(most, above, LIMIT)))

    def tried(self, tried: dict[str, tuple[Effect, str]]) -> list[dict[str, Any]]:
        gains = {each["effect"]: each for each in self.candidates()}
        named = {self.names[name] for name in self.choice.effects}
        rows = []
        for name, (_, why) in tried.items():
            row = gains.get(name)
            said = why or ("" if row is None else _said(row, name in named))
            rows.append(
                {"effect": name, "applicable": not why, "accepted": name in named, "why": said}
            )
        order = list(gains)
        return sorted(rows, key=lambda r: order.index(r["effect"]) if r["effect"] in gains else 99)

    def detectable(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Size of each amplitude that would be named four times in five, all else refitted."""
        base, space, found = self.found.base, self.model.space, {}
        for guess in self.found.guesses:
            effect = space.effects[guess.effect]
            _, curvature = projected(base, guess.columns)
            sizes = {}
            for number, name in enumerate(amplitude_names(effect)):
                each = space.directions[space.place(name)]
                least = 1.0 / np.sqrt(max(float(curvature[number, number]), 1e-30))
                needed = np.sqrt(LIMIT + PRICE * (len(space.of(guess.effect)) - 1))
                size = (needed + POWER_80) * least * each.scale * np.sqrt(self.found.unit)
                sizes[name.rpartition(".")[2]] = _size(size, each.low, each.high, self.unit(name))
            found[self.names[guess.effect]] = sizes
        return found

    def confusability(self) -> dict[str, Any]:
        """Cosines between the marks of the effects that come nearest, and of those named."""
        rows = [each["effect"] for each in self.candidates()]
        known = {self.names[guess.effect]: guess.columns for guess in self.found.guesses}
        names = [name for name in rows if name in known][:COMPARED]
        base = self.found.base
        cosines = [[round(likeness(base, known[a], known[b]), 3) for b in names] for a in names]
        return {"effects": names, "cosines": cosines}

    def unit(self, name: str) -> str:
        return self.model.whole.parameters.declared[name].unit

    def next_run(self) -> dict[str, Any] | None:
        """The run worth recording where the verdict names no single effect but some gain."""
        kind, trials = self.choice.kind, self.found.trials
        if kind not in ("one_of", "unknown") or not trials:
            return None
        known = _entries(self.known)
        run = next_run(self.campaign.plant, self.found, known)
        names = [self.names.get(name, name) for name in run["separates"]] if run else []
        return run and {**run, "separates": names}

    def refitted(self) -> Plant:
        """The plant as it came, refitted, or refitted with the effects that were found."""
        plant, choice = self.campaign.plant, self.choice
        if choice.kind == "no_gap":
            return plant
        space = self.model.space
        named = [
            e for n, e in space.effects.items() if self.spread.keys() & set(space.of(n).tolist())
        ]
        values = space.values(choice.point.x, self.owner())
        grown = plant.with_effects(*named)
        return grown.with_values({n: v for n, v in values.items() if n in grown.parameters})

    def owner(self) -> str:
        """Whose own parameters a hand.toml takes: those of the thing that the hand has itself."""
        for group in self.model.groups:
            same = all(group.nominal[n] == self.campaign.plant.parameters[n] for n in group.own)
            if group.own and same:
                return group.owner
        return ""


def _entries(pieces: list[Segment]) -> list[Entry]:
    return [piece.entry for piece in pieces]


def _said(row: dict[str, Any], named: bool) -> str:
    if named:
        return "accepted"
    gain = row["evidence"] ** 2
    if gain < LIMIT:
        return f"lowers the misfit by {gain:.0f}; a name needs {LIMIT:.0f}"
    return f"lowers the misfit by {gain:.0f}, which the verdict weighs"


def _size(size: float, low: float, high: float, unit: str) -> dict[str, Any]:
    largest = max(abs(low), abs(high))
    if size <= largest:
        return {"value": float(size), "unit": unit}
    reason = f"even the largest size inside its bounds, {largest:g}, would be missed"
    return {"value": None, "unit": unit, "reason": reason}
