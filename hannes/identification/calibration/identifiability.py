"""The answer for every parameter: its value, its interval, and whether it is identified."""

from dataclasses import dataclass, replace

import numpy as np

from hannes.core import former_names
from hannes.identification.calibration.intervals import Spread
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.tuning import CALIBRATION

NORMAL = 1.96

IDENTIFIED, AT_BOUND = "identified", "at its bound"
NOT_IDENTIFIED, CONFOUNDED = "not identified", "confounded"


@former_names.attributes({"given": "nominal"})
@dataclass(frozen=True)
class Answer:
    """One parameter after a calibration; SI, `low` and `high` bound its 95 % interval.

    nominal:   its value before
    label:     identified, at its bound, not identified, confounded (with `partners`)
    reason:    the label in words
    deviation: one standard deviation, by run;  freedom: its degrees of freedom
    textbook:  interval by the usual covariance, for contrast
    skewed:    whether the interval comes from a profile, because it is asymmetric
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    nominal: float
    label: str
    partners: tuple[str, ...]
    reason: str
    deviation: float
    freedom: float
    textbook: tuple[float, float]
    skewed: bool

    @property
    def identified(self) -> bool:
        """True where the interval is reliable."""
        return self.label == IDENTIFIED


def answers(found: State, spread: Spread, sides: np.ndarray, lack_of_fit: str = "") -> list[Answer]:
    """Answers in the order of the plan; `sides` are half-widths below and above, scaled, (2, p).

    `lack_of_fit` says why the model does not fit, "" where it does: then nothing is identified.
    """
    made = [_answer(found, spread, sides, place) for place in range(len(found.plan.names))]
    if not lack_of_fit:
        return made
    return [
        replace(each, label=NOT_IDENTIFIED, reason=lack_of_fit) if each.identified else each
        for each in made
    ]


def _answer(found: State, spread: Spread, sides: np.ndarray, place: int) -> Answer:
    name, scale = found.plan.names[place], float(found.scales.scale[place])
    declared = found.model.plant.parameters.declared[name]
    value, bounds = found.values[name], found.plan.bounds[name]
    low, high = value - scale * sides[0, place], value + scale * sides[1, place]
    usual = NORMAL * scale * float(spread.textbook[place])
    label, partners, reason = _label(found, spread, sides, place)
    lopsided = not np.isclose(sides[0, place], sides[1, place], rtol=0.05)
    return Answer(
        name,
        declared.unit,
        value,
        max(low, bounds[0]),
        min(high, bounds[1]),
        found.model.plant.parameters[name],
        label,
        partners,
        reason,
        scale * float(spread.deviation[place]),
        float(spread.freedom[place]),
        (value - usual, value + usual),
        bool(lopsided),
    )


def _label(
    found: State, spread: Spread, sides: np.ndarray, place: int
) -> tuple[str, tuple[str, ...], str]:
    names = found.plan.names
    if place in found.on_bound:
        return AT_BOUND, (), "it ended at a bound: widen the bound, or question the model"
    if _silent(found, place):
        return NOT_IDENTIFIED, (), "it moves nothing in these recordings"
    width = _width(found, spread, sides, place)
    if width <= found.plan.limit:
        return IDENTIFIED, (), _alone(spread, place)
    partners, left = _partners(spread.covariance, place, width, found.plan.limit)
    known = f"known to ±{100 * width:.2g} %"
    if not partners:
        return NOT_IDENTIFIED, (), known
    shown = tuple(names[each] for each in partners)
    reason = f"{known}; to ±{100 * left:.2g} % were {' and '.join(shown)} known"
    return CONFOUNDED, shown, reason


def _alone(spread: Spread, place: int) -> str:
    if spread.alone[place]:
        return "one run alone decides it: its interval is by the assumed scatter of runs"
    return ""


def _silent(found: State, place: int) -> bool:
    pairs = zip(found.whitenings, found.columns, strict=True)
    information = sum(float(np.sum(white(columns[place]) ** 2)) for white, columns in pairs)
    return information < CALIBRATION.no_information * float(found.scales.prior[place]) ** 2


def _width(found: State, spread: Spread, sides: np.ndarray, place: int) -> float:
    """Half-width relative to the value, or to a part of its scale where that is larger."""
    reach = max(float(sides[:, place].max()), NORMAL * float(spread.working[place]))
    value = abs(found.values[found.plan.names[place]]) / float(found.scales.scale[place])
    return reach / max(value, CALIBRATION.least_value)


def _partners(
    covariance: np.ndarray, place: int, width: float, limit: float
) -> tuple[list[int], float]:
    """Parameters that would narrow this one, were they known, and its width then."""
    found: list[int] = []
    left = covariance.copy()
    whole = covariance[place, place]
    while len(found) < CALIBRATION.max_partners:
        shared = left[place] ** 2 / np.maximum(np.diag(left), 1e-300)
        shared[[place, *found]] = 0.0
        best = int(np.argmax(shared))
        if shared[best] < CALIBRATION.least_partner * left[place, place]:
            break
        left = left - np.outer(left[best], left[best]) / left[best, best]
        found.append(best)
        narrow = width * float(np.sqrt(left[place, place] / whole))
        if narrow <= limit:
            return found, narrow
    narrow = width * float(np.sqrt(max(left[place, place], 0.0) / whole))
    explained = 1.0 - left[place, place] / whole
    return (found, narrow) if found and explained > CALIBRATION.explained_variance else ([], width)
