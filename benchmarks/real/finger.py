"""RH56: the lag of the force reading is named, and what each model leaves on trials not fitted."""

from collections.abc import Sequence

import numpy as np

from benchmarks.harness import Row, must_show
from benchmarks.real import blocks
from hannes.campaigns.segments import Segment, in_roles, split_campaign
from hannes.commands.diagnose import Diagnosis
from hannes.identification.holdout.least_squares import Fitted, WeightedResidual, fit
from hannes.identification.residuals import inflated_noise_floors

EFFECT = "force_lag"
TIME = (0.14, 0.15)  # s, of an independent fit
MOST = 35.0  # counts


def figures(found: Diagnosis) -> tuple[list[Row], list[Row]]:
    """What each model leaves, and what must be shown of the verdict."""
    segments = split_campaign(found.campaign)[0]
    shown = in_roles(segments, "show")
    static = _base(found, in_roles(segments, "fit"))
    rows = [_left("the contact law alone", static, shown, found)]
    rows += [
        _left(f"with {each.name}", each.fitted, shown, found)
        for each in found.trials
        if each.fitted is not None
    ]
    after = found.verdict.gap["force"]["after"]
    named = found.verdict.effects == [EFFECT]
    bounds = [must_show("RH56: named as force_lag, alone", float(named), 1.0, named)]
    lag = next((row for row in rows if row["model"] == f"with {EFFECT}"), None)
    if lag is None:
        return rows, bounds
    said = found.verdict.parameters.get(f"{EFFECT}.time", {"value": 0.0, "low": 0.0, "high": 0.0})
    time, ends = said["value"], {key: said[key] for key in ("low", "high")}
    error, reach = lag["counts"], {key: lag[key] for key in ("low", "high")}
    return rows, [
        *bounds,
        {**must_show("RH56: time constant, at least [s]", time, TIME[0], time >= TIME[0]), **ends},
        {**must_show("RH56: time constant, at most [s]", time, TIME[1], time <= TIME[1]), **ends},
        {**must_show("RH56, shown trials: error, fitted on 1 modulo 5 [counts]", error, MOST,
                     error <= MOST), **reach},
        must_show("RH56, shown trials: error of the verdict [counts]", after, MOST, after <= MOST),
    ]  # fmt: skip


def _base(found: Diagnosis, segments: Sequence[Segment]) -> Fitted:
    """The base refitted on these segments, weighed as in the diagnosis."""
    plant = found.campaign.plant
    floor = WeightedResidual(plant, segments, found.noise_floors)
    rough = fit(floor, plant)
    return fit(
        WeightedResidual(plant, segments, inflated_noise_floors(found.noise_floors, floor, rough)),
        plant,
        rough.values,
    )


def _left(model: str, fitted: Fitted, shown: Sequence[Segment], found: Diagnosis) -> Row:
    """RMS of what a model leaves on the segments shown."""
    raw = WeightedResidual(found.campaign.plant, shown, found.noise_floors).raw(
        fitted.plant, fitted.values
    )
    sums = blocks.squares([(each["force"], np.ones(each["force"].size)) for each in raw])
    error = blocks.row("", sums, lambda s: float(np.sqrt(s[0] / s[1])))
    return {"machine": "RH56, show", "model": model, "counts": error["value"],
            "low": error["low"], "high": error["high"]}  # fmt: skip
