"""Effect sizes with intervals; an effect whose interval contains off is not named.

A further effect is named for its reduction of chi-squared. Its final fit may show a size so
uncertain that its interval contains off. Then there is a remainder, and not surely that effect.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.baseline import FINE
from hannes.identification.diagnosis.decision import Decision
from hannes.identification.diagnosis.final_fit import final_fit
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import faded
from hannes.identification.diagnosis.score_test import amplitude_names
from hannes.identification.diagnosis.tuning import FIT

NORMAL = 1.96  # standard deviations on each side of a normal 95 % interval
COARSE = "; the final fit was ended at its bound: its sizes may be coarse"
Progress = Callable[[str], None]


def with_sizes(
    decision: Decision, seed: int, variance_factor: float, progress: Progress
) -> tuple[Decision, dict[int, float]]:
    """The decision with its effects fitted, and the standard deviation of each parameter, by index.

    variance_factor: by which chi-squared is divided
    """
    if not decision.effects:
        return decision, {}
    progress(f"{' and '.join(decision.effects)}, how large".replace("_", " "))
    fit = final_fit(decision.point, decision.effects, FINE, seed, variance_factor)
    if len(decision.effects) > 1 and decision.kind in ("named", "named_with_remainder"):
        surest = {
            name: _surely(fit.point, name, fit.deviations, variance_factor)
            for name in decision.effects
        }
        other = min(surest, key=lambda name: surest[name])
        point = faded(decision.point, other) if surest[other] <= 1.0 else None
        if point is not None:
            reason = f"{decision.reason}; the size of {other.replace('_', ' ')} may be zero"
            kept = tuple(name for name in decision.effects if name != other)
            left = Decision("named_with_remainder", kept, reason, point)
            return with_sizes(left, seed, variance_factor, progress)
    reason = f"{decision.reason}{COARSE if fit.cut_short else ''}"
    return replace(decision, point=fit.point, reason=reason), fit.deviations


def may_be_zero(decision: Decision, spread: dict[int, float], variance_factor: float) -> bool:
    """Whether the interval of all sizes of the one effect that is named contains off.

    spread: standard deviation of each parameter, by index
    """
    if len(decision.effects) != 1:
        return False
    return _surely(decision.point, decision.effects[0], spread, variance_factor) <= 1.0


def _surely(
    point: Linearisation, effect: str, spread: dict[int, float], variance_factor: float
) -> float:
    """Distance of an effect's most certain size from off, over the half-width of its interval."""
    space = point.space
    places = [space.place(name) for name in amplitude_names(space.effects[effect])]
    fitted = [place for place in places if place in spread]
    return max(abs(float(point.x[k])) / (half_width(variance_factor) * spread[k]) for k in fitted)


def interval(
    point: Linearisation, place: int, deviation: float, variance_factor: float
) -> dict[str, float]:
    """Value of one parameter and the ends of its 95 % interval within bounds [SI]."""
    each = point.space.parameters[place]
    value = float(each.value(point.x[place]))
    reach = half_width(variance_factor) * deviation * each.scale
    return {
        "value": value,
        "low": max(each.low, value - reach),
        "high": min(each.high, value + reach),
    }


def half_width(variance_factor: float) -> float:
    """Standard deviations from a value to an end of its interval."""
    return NORMAL * FIT.interval_widening * float(np.sqrt(variance_factor))
