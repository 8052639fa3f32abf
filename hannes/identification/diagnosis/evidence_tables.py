"""The tables of a verdict: effects by evidence, minimum detectable sizes, confusability."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from hannes.core.effect import Effect
from hannes.identification.diagnosis.score_test import (
    amplitude_names,
    cosine_similarity,
    projected,
)
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT

POWER_80 = 0.842  # standard deviations above a limit for 80 % power


class EvidenceTables:
    """Tables of what a search found; names: effect -> name by which it can be found again."""

    def __init__(self, found: SearchResult, names: Mapping[str, str]) -> None:
        self.found, self.names = found, names

    def candidates(self) -> list[dict[str, Any]]:
        """Every effect that was screened, best first; reductions of refitted ones are exact.

        Of several named together, an effect has what is lost without it, where that is more.
        """
        exact = {trial.effects[0]: trial for trial in self.found.trials}
        joint = self.found.joint
        beside, without = (joint.losses, joint.without) if joint else ({}, {})
        rows = []
        for guess in self.found.guesses:
            trial, name = exact.get(guess.effect), guess.effect
            delta_chi2 = (
                trial.delta_chi2 if trial else guess.delta_chi2 / self.found.variance_factor
            )
            delta_chi2 = max(delta_chi2, beside.get(name, delta_chi2))
            rows.append(
                {
                    "effect": self.names[guess.effect],
                    "evidence": float(np.sqrt(max(0.0, delta_chi2))),
                    "gain_select": self._share(delta_chi2),
                    "refitted": trial is not None or name in without,
                    "confusable_with": [self.names[name] for name in trial.confusable]
                    if trial
                    else [],
                    "sizes": self._sizes(trial) if trial else {},
                }
            )
        return sorted(rows, key=lambda row: -row["evidence"])

    def _sizes(self, trial: Trial) -> dict[str, dict[str, Any]]:
        """Value [SI] and unit of each parameter of an effect where it was fitted alone."""
        space, x = trial.point.space, trial.point.x
        names = {place: space.parameters[place].name for place in space.of(*trial.effects).tolist()}
        return {
            name.rpartition(".")[2]: {
                "value": float(space.parameters[place].value(x[place])),
                "unit": self._unit(name),
            }
            for place, name in names.items()
        }

    def _share(self, delta_chi2: float) -> float:
        """A reduction as a share of the largest one, or of what lies above the expected value."""
        trials = [*self.found.trials, *([self.found.joint.trial] if self.found.joint else [])]
        most = max([trial.delta_chi2 for trial in trials], default=0.0)
        above = (self.found.baseline.chi2 - self.found.bins) / self.found.variance_factor
        return max(0.0, float(delta_chi2 / max(most, above, SEARCH.name_limit)))

    def tried(
        self, tried: Mapping[str, tuple[Effect, str]], effects: Sequence[str]
    ) -> list[dict[str, Any]]:
        """Every effect, whether it is applicable and accepted, and why not.

        tried: name -> effect, why it cannot be tried or "";  effects: those named
        """
        reductions = {each["effect"]: each for each in self.candidates()}
        named = {self.names[name] for name in effects}
        most = max((each["evidence"] for each in reductions.values()), default=0.0)
        rows = []
        for name, (_, why) in tried.items():
            row = reductions.get(name)
            reason = why or ("" if row is None else _reason(row, name in named, most))
            if not why and row is not None and name not in named and self._missed(name):
                reason += "; could not have been found: even the end of its range would be missed"
            rows.append(
                {"effect": name, "applicable": not why, "accepted": name in named, "why": reason}
            )
        order = list(reductions)
        return sorted(
            rows, key=lambda r: order.index(r["effect"]) if r["effect"] in reductions else 99
        )

    def detectable(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Size of each amplitude that would be named with 80 % power, all else refitted."""
        return self._detectable

    @cached_property
    def _detectable(self) -> dict[str, dict[str, dict[str, Any]]]:
        baseline, found = self.found.baseline, {}
        space = baseline.space
        for guess in self.found.guesses:
            effect = space.effects[guess.effect]
            _, hessian = projected(baseline, guess.signature)
            sizes = {}
            for number, name in enumerate(amplitude_names(effect)):
                each = space.parameters[space.place(name)]
                least = 1.0 / np.sqrt(max(float(hessian[number, number]), 1e-30))
                needed = np.sqrt(
                    SEARCH.name_limit + SEARCH.parameter_price * (len(space.of(guess.effect)) - 1)
                )
                size = (
                    (needed + POWER_80) * least * each.scale * np.sqrt(self.found.variance_factor)
                )
                sizes[name.rpartition(".")[2]] = _size(size, each.low, each.high, self._unit(name))
            found[self.names[guess.effect]] = sizes
        return found

    def _missed(self, name: str) -> bool:
        """Whether none of an effect's amplitudes would be named, however large in its range."""
        sizes = self._detectable.get(name, {})
        return bool(sizes) and all(each["value"] is None for each in sizes.values())

    def confusability(self) -> dict[str, Any]:
        """Cosine similarities of the signatures of the best effects and of those named."""
        rows = [each["effect"] for each in self.candidates()]
        known = {self.names[guess.effect]: guess.signature for guess in self.found.guesses}
        names = [name for name in rows if name in known][: VERDICT.compared]
        baseline = self.found.baseline
        cosines = [
            [
                1.0 if a == b else round(cosine_similarity(baseline, known[a], known[b]), 3)
                for b in names
            ]
            for a in names
        ]
        return {"effects": names, "cosines": cosines}

    def _unit(self, name: str) -> str:
        return self.found.baseline.space.declared(name).unit


def _reason(row: dict[str, Any], named: bool, most: float) -> str:
    if named:
        return "accepted"
    delta_chi2 = row["evidence"] ** 2
    if not row["refitted"]:
        return f"would lower the misfit by {delta_chi2:,.0f} by a linear estimate; not fitted"
    if delta_chi2 < SEARCH.name_limit:
        return f"lowers the misfit by {delta_chi2:,.0f}; a name needs {SEARCH.name_limit:.0f}"
    if row["evidence"] < most:
        return f"lowers the misfit by {delta_chi2:,.0f}, less than what explains most"
    return f"lowers the misfit by {delta_chi2:,.0f}; the verdict's reason says why it is no name"


def _size(size: float, low: float, high: float, unit: str) -> dict[str, Any]:
    largest = max(abs(low), abs(high))
    if size <= largest:
        return {"value": float(size), "unit": unit}
    reason = f"even the largest size inside its bounds, {largest:g}, would be missed"
    return {"value": None, "unit": unit, "reason": reason}
