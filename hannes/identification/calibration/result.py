"""The result of a calibration, as plain data and as a sentence."""

import json
import math
import re
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from hannes.campaigns.campaign import Campaign
from hannes.core import former_names
from hannes.core.by_value import ByValue
from hannes.core.io.provenance import versions
from hannes.identification.calibration.data_check import DataIssues
from hannes.identification.calibration.far_value import FarValue
from hannes.identification.calibration.identifiability import (
    AT_BOUND,
    CONFOUNDED,
    NOT_IDENTIFIED,
    Answer,
)
from hannes.identification.calibration.intervals import Spread
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.missing_effect import MissingEffect
from hannes.identification.calibration.repeatable_residual import RepeatableResidual
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.plants.protocol import Plant

MOST_WARNINGS = 5  # in a terminal; files hold all
_MILLI = re.compile(
    r"(N|m|s|A|V)(?![\w^²³])"
)  # units in which a small value is printed in thousandths


@former_names.attributes({"remains": "repeatable_residual", "findings": "data_issues"})
@dataclass(frozen=True, eq=False, repr=False)
class Fit(ByValue):
    """Everything that a calibration found; `calibrate` adds the campaign's view of it.

    data_issues: what the data check found and the campaign accepted, with the file's name
    gap:        channel -> RMS as_given, after, recorded, floor [its unit], on the recordings that
                were not fitted; empty where none was held out
    fitted_gap: the same on those that were fitted
    """

    campaign: Campaign
    data_issues: DataIssues
    found: State
    spread: Spread
    answers: tuple[Answer, ...]
    repeatable_residual: RepeatableResidual
    missing: MissingEffect
    far: tuple[FarValue, ...]
    gap: dict[str, dict[str, float]]
    fitted_gap: dict[str, dict[str, float]]
    floor_from: str
    seed: int

    def compared(self) -> tuple[Any, ...]:
        """What a calibration says: two that say the same are equal."""
        return (self.json(),)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.sentence})"

    @property
    def plant(self) -> Plant:
        """The plant at the fitted values."""
        return self.campaign.plant.with_values(self.found.all_values)

    @property
    def agreeing(self) -> list[bool]:
        """For each start, whether it ended where the result is, as far as that is identified."""
        reach = self.spread.reach
        known = np.array([each.identified for each in self.answers])
        reference = min(self.found.starts, key=lambda each: each.cost, default=None)
        if reference is None:
            return []
        return [
            bool(
                start.cost <= reference.cost * CALIBRATION.agreeing_cost
                and np.all(
                    np.abs(start.ended - reference.ended)[known]
                    < CALIBRATION.agreeing_distance * reach[known]
                )
            )
            for start in self.found.starts
        ]

    @property
    def sentence(self) -> str:
        """The result in one sentence, the worst thing first."""
        parts = []
        if self.repeatable_residual.misleads:
            parts = ["the model does not fit these recordings"]
        elif self.missing.likely:
            parts = [f"the model likely lacks {self.missing.name}, or something like it"]
        elif self.far:
            names = " and ".join(each.name for each in self.far)
            parts = [f"farther from the given value than machines differ: {names}"]
        for label in (AT_BOUND, NOT_IDENTIFIED, CONFOUNDED):
            some = [each.name for each in self.answers if each.label == label]
            parts += [f"{label}: {', '.join(some)}"] if some else []
        count = sum(each.identified for each in self.answers)
        parts.append(f"{count} of {len(self.answers)} parameters identified")
        text = "; ".join(parts) + "."
        if self.found.interrupted:
            return f"Interrupted, best so far: {text}"
        return text[:1].upper() + text[1:]

    def plain(self) -> dict[str, Any]:
        """Content of calibration.json."""
        return {
            "status": "interrupted" if self.found.interrupted else "converged",
            "parameters": {each.name: _plain(each) for each in self.answers},
            "findings": [{"file": name, **asdict(each)} for name, each in self.data_issues],
            "level": CALIBRATION.level,
            "intervals_by": self.spread.unit,
            "gap": self._with_units(self.gap),
            "fitted_gap": self._with_units(self.fitted_gap),
            "floor_from": self.floor_from,
            "remains": {
                "repeats": self.repeatable_residual.repeats,
                "chance": self.repeatable_residual.chance,
                "smallest_chance": self.repeatable_residual.smallest,
                "times_spread": self.repeatable_residual.ratio,
                "times_spread_at_most": finite(self.repeatable_residual.hidden),
                "share": self.repeatable_residual.share,
                "common": self.repeatable_residual.common,
                "sentence": self.repeatable_residual.sentence,
            },
            "missing": {**asdict(self.missing), "likely": self.missing.likely},
            "far": [asdict(each) for each in self.far],
            "starts": self._starts(),
            "runs": self._runs(),
            "recordings": {
                role: [each.name for each in self.campaign.of(role)]
                for role in ("fit", "select", "show")
            },
            "assumed": self.assumed,
            "doubted": self._uncertain(),
            "misfit": self.found.costs,
            "seed": self.seed,
            "versions": versions(),
        }

    def json(self) -> str:
        """Text of calibration.json."""
        return json.dumps(self.plain(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    def _with_units(self, gap: dict[str, dict[str, float]]) -> dict[str, dict[str, Any]]:
        channels = self.plant.channels
        return {name: {"unit": channels[name], **each} for name, each in gap.items()}

    def _starts(self) -> list[dict[str, Any]]:
        return [
            {
                "misfit": start.cost if np.isfinite(start.cost) else None,
                "agrees": agrees,
                "from": self.found.scales.values(start.begun),
                "to": self.found.scales.values(start.ended),
            }
            for start, agrees in zip(self.found.starts, self.agreeing, strict=True)
        ]

    def _uncertain(self) -> dict[str, dict[str, Any]]:
        """Parameters that were uncertain but not asked for, and their most likely values."""
        plant, found = self.campaign.plant, self.found
        pairs = zip(found.plan.doubt.items(), found.uncertain_values, strict=False)
        return {
            name: {
                "value": found.all_values[name],
                "unit": plant.parameters.declared[name].unit,
                "given": plant.parameters[name],
                "deviations": float(at),
            }
            for (name, _), at in pairs
        }

    def _runs(self) -> list[dict[str, Any]]:
        """When each run started, and in what it most likely differed from the others."""
        found, rows = self.found, []
        for place, view in enumerate(found.model.views):
            blamed = found.whitenings[place].attributed(-found.residuals[place])
            sizes = dict(zip(found.plan.nuisance.items(), blamed, strict=False))
            rows.append(
                {
                    "file": view.entry.name,
                    "condition": view.entry.condition,
                    "starts_late_s": float(found.start_offsets[place]),
                    "differs": {name: float(size * at) for (name, size), at in sizes.items()},
                }
            )
        return rows

    def summary(self) -> str:
        """Some lines for a terminal."""
        width = max(len(each.name) for each in self.answers)
        lines = [self.sentence]
        for each in self.answers:
            note = "" if each.identified else f"  {each.label}"
            lines.append(f"  {each.name:<{width}}  {value_text(each)}{note}")
        lines += self.remaining
        return "\n".join([*lines, *self._warnings()])

    @property
    def misleads(self) -> bool:
        """Whether the model, or what was given of it, is wrong in some way."""
        return self.repeatable_residual.misleads or self.missing.likely or bool(self.far)

    @property
    def remaining(self) -> list[str]:
        """What remains and what was assumed, a sentence each."""
        said = [self.repeatable_residual.sentence, self.missing.sentence]
        said += [each.sentence for each in self.far]
        return [*(f"{text}." for text in said if text), *self.assumed]

    @property
    def assumed(self) -> list[str]:
        """What was taken of the rest and of the controller, a sentence each."""
        plan = self.found.plan
        said = [plan.rest.sentence(plan.doubt, plan.parts), plan.controller]
        return [f"{text[:1].upper()}{text[1:]}." for text in said if text]

    def _warnings(self) -> list[str]:
        more = len(self.data_issues) - MOST_WARNINGS
        lines = [f"{name}: {each}" for name, each in self.data_issues[:MOST_WARNINGS]]
        return [*lines, f"{more} more warnings: see `hannes check`"] if more > 0 else lines


def value_text(answer: Answer) -> str:
    """`18.083 mN m/A (18.071 to 18.095)`: as many digits as the interval justifies."""
    small = bool(_MILLI.match(answer.unit)) and 0.0 < abs(answer.value) < 0.1
    factor, unit = (1e3, f"m{answer.unit}") if small else (1.0, answer.unit)
    value, low, high = (factor * each for each in (answer.value, answer.low, answer.high))
    width = max(high - low, 1e-12 * abs(value), 1e-300)
    places = int(np.clip(2 - np.floor(np.log10(width)), 0, 12))
    shown = f"{value:.{places}f}" + ("" if unit == "1" else f" {unit}")
    return f"{shown} ({low:.{places}f} to {high:.{places}f})"


def finite(value: float) -> float | None:
    """JSON has no infinity."""
    return value if math.isfinite(value) else None


def _plain(answer: Answer) -> dict[str, Any]:
    return {
        "value": answer.value,
        "unit": answer.unit,
        "low": answer.low,
        "high": answer.high,
        "given": answer.nominal,
        "label": answer.label,
        "confounded_with": list(answer.partners),
        "reason": answer.reason,
        "deviation": answer.deviation,
        "degrees_of_freedom": answer.freedom if np.isfinite(answer.freedom) else None,
        "textbook": list(answer.textbook),
        "by_profile": answer.skewed,
    }
