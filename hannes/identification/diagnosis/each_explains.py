"""What each of several named effects explains of recordings that were not fitted.

One is taken away and the machine follows as far as the fit predicts. What the gap is larger by
then, only that effect explains. Two effects that do much the same explain little each.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hannes.campaigns.segments import Segment, in_roles
from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.before_after import left, simulated
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.fitted_deviations import with_deviations
from hannes.identification.diagnosis.hold_out_guard import Stages
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import without
from hannes.identification.residuals import pooled


def each_explains(
    stages: Stages, decision: Decision, variance_factor: float, names: Mapping[str, str]
) -> dict[str, dict[str, Any]]:
    """Effect -> the RMS that each channel has `without` it, and the share that it `explains`.

    The share is of what the refitted baseline leaves above the noise floor. Empty for a single
    effect or a class, and where a hand without one of them cannot be simulated.
    names: effect -> name by which it can be found again
    """
    unfitted, effects = in_roles(stages.segments, "show"), decision.effects
    if len(effects) < 2 or decision.kind == "one_of" or not unfitted:
        return {}
    point = stages.points[2]
    with point.model.work.in_any_case():
        places = np.array([_without(point, each) for each in effects])
        try:
            raws = _left(stages, unfitted, places, variance_factor)
        except ComputationFailed:
            return {}
    noise_floors = stages.noise_floors
    before = _above(pooled(stages.raw(1, "show"), noise_floors), noise_floors)
    after = _above(pooled(stages.raw(2, "show"), noise_floors), noise_floors)
    found = {}
    for effect, raw in zip(effects, raws, strict=True):
        gap = pooled(raw, noise_floors)
        share = _share(_above(gap, noise_floors) - after, before)
        found[names[effect]] = {"without": gap, "explains": share}
    return found


def _share(part: float, whole: float) -> float:
    """0 to 1; none where there is nothing to explain."""
    return min(1.0, max(0.0, part / whole)) if whole > 0.0 else 0.0


def _without(point: Linearisation, effect: str) -> np.ndarray:
    """The point without an effect, with the share of its work taken over that leaves least."""
    rows = without(point, (effect,))
    best: np.ndarray = rows[int(np.argmin(point.chi2_at(rows)))]
    return best


def _left(
    stages: Stages, unfitted: Sequence[Segment], places: np.ndarray, variance_factor: float
) -> list[Any]:
    """Simulated minus recorded at each of the points x; ComputationFailed where one fails."""
    point, entries = stages.points[2], [each.entry for each in unfitted]
    made = [[runs[0], *runs] for runs in simulated(point.model, entries, places)]
    if any(run is None for runs in made for run in runs):
        raise ComputationFailed("without an effect the machine cannot be simulated")
    whole = with_deviations(made, entries, [point] * len(places), variance_factor)
    names = list(stages.noise_floors)
    return [
        left(unfitted, [runs[1 + k] or {} for runs in whole], names) for k in range(len(places))
    ]


def _above(gap: Mapping[str, float], noise_floors: Mapping[str, float]) -> float:
    """Squared gap in noise floors, above one, all channels together."""
    return sum((size / noise_floors[name]) ** 2 - 1.0 for name, size in gap.items())
