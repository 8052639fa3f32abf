"""The profile of chi-squared along one parameter, all else following: its minimum and its width.

With contacts chi-squared has kinks within a standard deviation. Derivatives at one point then give
neither the minimum of a valley nor its width, and a fit ends in any of its local minima. So the
valley is followed both ways until chi-squared has risen (Venzon & Moolgavkar 1988), and a parabola
is fitted to all of that.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT


@dataclass(frozen=True)
class Profile:
    """Where chi-squared is least along a parameter, and its standard deviation there, in steps.

    lowest: the best fit met on the way
    """

    least: float
    deviation: float
    lowest: Linearisation = field(repr=False)


def profile(point: Linearisation, place: int, deviation: float) -> Profile | None:
    """The profile of one parameter, from a fit and its linear standard deviation.

    None where the minimum is not seen from both sides, as at an end of a range. The fit's model
    holds its effects: a parameter that is held is not active.
    """
    sides = [list(_walk(point, place, side * FIT.profile_step * deviation)) for side in (-1.0, 1.0)]
    met = [point, *sides[0], *sides[1]]
    lowest = min(met, key=lambda each: each.chi2)
    near = [
        [e for e in side if e.chi2 < lowest.chi2 + FIT.other_valley] for side in ([point], *sides)
    ]
    if not all(near):
        return None
    kept = [each for side in near for each in side]
    away = np.array([each.x[place] - point.x[place] for each in kept]) / deviation
    above = np.array([each.chi2 for each in kept]) - lowest.chi2
    quadratic, linear, _ = np.polyfit(away, above, 2, w=1.0 / (FIT.local_minima + above))
    if quadratic <= 0.0:
        return None
    least = float(np.clip(-linear / (2.0 * quadratic), away.min(), away.max()))
    return Profile(float(point.x[place]) + deviation * least, deviation / quadratic**0.5, lowest)


def held_at(
    point: Linearisation, places: np.ndarray, values: np.ndarray, below: float = np.inf
) -> Linearisation | None:
    """The fit with some parameters held at values of x; None where that cannot be simulated.

    below: chi-squared that it must reach to count. One that does not come near is given up
    """
    x = point.x.copy()
    x[places] = values
    there = point.with_active(np.setdiff1d(point.active, places)).moved(x, np.array([], int))
    there = there and fitted(there, 4)
    if there is None or there.predicted_reduction < FIT.foreseen:
        return there
    return settled(there, FIT.converged, below, FIT.settled_finally)


def _walk(point: Linearisation, place: int, step: float) -> Iterator[Linearisation]:
    """Fits with one parameter held, ever further; a first step that is too long is shortened."""
    space, here, lowest = point.space, point, point.chi2
    for _ in range(FIT.profile_steps):
        value = float(np.clip(here.x[place] + step, space.low[place], space.high[place]))
        if value == here.x[place]:
            return
        most = lowest + FIT.other_valley
        there = held_at(here, np.array([place]), np.array([value]), most)
        if there is None or there.chi2 > most:
            if here is not point:
                return
            step *= FIT.profile_shrink
            continue
        yield there
        here, lowest, step = there, min(lowest, there.chi2), FIT.profile_growth * step
        if there.chi2 > lowest + FIT.profile_rise:
            return
