"""The shape of what is missing, held against recordings that were not fitted, and its table."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hannes.campaigns.segments import in_roles
from hannes.identification.diagnosis.before_after import simulated
from hannes.identification.diagnosis.effect_sizes import half_width, interval
from hannes.identification.diagnosis.fitted_deviations import with_deviations
from hannes.identification.diagnosis.gauss_newton import standard_deviations
from hannes.identification.diagnosis.hold_out_guard import Stages
from hannes.identification.diagnosis.shape.likeliest import (
    Described,
    Progress,
    applicable,
    likeliest,
)
from hannes.identification.diagnosis.trials import SearchResult
from hannes.identification.diagnosis.tuning import FIT, SHAPE
from hannes.identification.gap_change import too_faint
from hannes.identification.residuals import tabled
from hannes.identification.verdict import explained
from hannes.plants.protocol import Plant

NONE_FITS = "none lowers the misfit by enough"
TOO_LITTLE = (
    f"on recordings that were not fitted it closes less than {100.0 * SHAPE.least_closed:.0f} % of "
    "the reducible gap"
)


@dataclass(frozen=True)
class Shape:
    """What a verdict holds of the shape, and the machine that has it.

    table: of verdict.json;  described: the fit, and plant: the machine with it; None where no
    generic disturbance helps
    """

    table: dict[str, Any]
    described: Described | None = None
    plant: Plant | None = None


def shape_of(found: SearchResult, stages: Stages, owner: str, progress: Progress) -> Shape:
    """The likeliest generic disturbance of those that unfitted recordings do not oppose.

    stages: of which the second is the refitted baseline, or what stands for it
    owner: whose own parameters the machine takes, see ParameterSpace.values
    """
    if not applicable(stages.plant):
        return Shape({})
    refused: list[Shape] = []
    for described in likeliest(found, progress):
        held = _held(found, described, stages)
        closes = 0.0 if (why := held.refusal(1, 2)) else _closed(held)
        shown = closes >= SHAPE.least_closed
        if not why and (shown or _cannot_show(described, held)):
            shares = {"closes": closes, "shown": shown, "explains": _explains(described)}
            table = _table(described, found.variance_factor) | shares
            return Shape(table, described, _machine(described, owner, held))
        refused.append(Shape(_nothing(f"{described.description.words}: {why or TOO_LITTLE}")))
    return refused[0] if refused else Shape(_nothing(NONE_FITS))


def _cannot_show(described: Described, held: Stages) -> bool:
    """Whether unfitted recordings cannot show a law that leaves next to nothing of the misfit.

    Where it changes less than runs may differ by, no gap is seen to fall, however right it is.
    """
    return _explains(described) >= SHAPE.explains and too_faint(held.change(1, 2))


def _explains(described: Described) -> float:
    """Share of the misfit beyond noise that is gone, 0 to 1."""
    beyond = described.base.chi2 - described.base.residual.size
    return min(1.0, max(0.0, described.reduction / beyond)) if beyond > 0.0 else 0.0


def _nothing(why: str) -> dict[str, Any]:
    return {"name": "", "why_not": why}


def _held(found: SearchResult, best: Described, stages: Stages) -> Stages:
    """The stages with the described machine as the last."""
    model = best.base.model
    entries = [each.entry for each in stages.segments]
    places = np.array([each.x for each in (best.nominal, best.base, best.point)])
    with model.work.in_any_case():
        made = with_deviations(
            simulated(model, entries, places),
            entries,
            (best.base, best.point),
            found.variance_factor,
        )
    if any(each[2] is None for each in made):
        return replace(stages, failed=stages.failed | {2})
    runs = [each[2] for each in made if each[2]]
    points = (*stages.points[:2], best.point)
    return replace(stages, points=points, runs=(*stages.runs[:2], runs), failed=stages.failed - {2})


def _closed(held: Stages) -> float:
    """Share of the reducible gap on the recordings in role show that is closed."""
    raws = {key: held.raw(k, "show") for key, k in (("as_given", 0), ("before", 1), ("after", 2))}
    unfitted = in_roles(held.segments, "show")
    return explained(tabled(raws, unfitted, held.plant.channels, held.noise_floors))


def _machine(best: Described, owner: str, held: Stages) -> Plant:
    """The plant with the generic disturbance, and with what was refitted beside it.

    Where earlier runs set something of it, it is the machine after all of them.
    """
    space, entries = best.point.space, [each.entry for each in held.segments]
    plant = best.base.model.with_parts_at({}).small.with_effects(best.description.effect)
    values = space.values(best.point.x, owner) | space.after_all(entries)
    return plant.with_values({n: v for n, v in values.items() if n in plant.parameters})


def _table(best: Described, variance_factor: float) -> dict[str, Any]:
    """Of verdict.json: the value over its axis with its 95 % band, and the numbers behind it."""
    description, effect, point = best.description, best.description.effect, best.point
    left = max(variance_factor, point.chi2 / point.residual.size)  # wider by what is left
    spread, values = _covariance(best), list(_values(best).values())
    places = np.linspace(*description.ends, SHAPE.places)
    line, slopes = description.at(places, values), description.slopes(places, values)
    reach = half_width(left) * np.sqrt(np.einsum("kn,kl,ln->n", slopes, spread, slopes))
    return {
        "name": effect.name,
        "meaning": description.words,
        "axis": {"name": description.axis, "unit": description.unit, "values": places.tolist()},
        "value": {
            "name": description.value,
            "unit": description.value_unit,
            "values": line.tolist(),
            "low": (line - reach).tolist(),
            "high": (line + reach).tolist(),
        },
        "parameters": _parameters(best, left),
        "why_not": "",
    }


def _parameters(best: Described, variance_factor: float) -> dict[str, dict[str, Any]]:
    """Value and 95 % interval of each number within its bounds [SI], by full name."""
    point, found = best.point, {}
    deviations = dict(zip(point.active.tolist(), standard_deviations(point).tolist(), strict=True))
    for place in point.space.of(best.description.effect.name).tolist():
        name = point.space.parameters[place].name
        size = interval(point, place, deviations[place], variance_factor)
        found[name] = {"unit": point.space.declared(name).unit, **size}
    return found


def _values(best: Described) -> Mapping[str, float]:
    """Parameters of the generic disturbance by full name [SI]."""
    space, x = best.point.space, best.point.x
    places = space.of(best.description.effect.name)
    parameters = [space.parameters[place] for place in places]
    return {p.name: float(p.value(x[k])) for p, k in zip(parameters, places, strict=True)}


def _covariance(best: Described) -> np.ndarray:
    """Of these parameters [SI], all else refitted, (k, k)."""
    point = best.point
    places = point.space.of(best.description.effect.name)
    rows = np.searchsorted(point.active, places)
    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    scales = np.array([point.space.parameters[k].scale for k in places])
    return np.asarray(inverse[np.ix_(rows, rows)] * np.outer(scales, scales))
