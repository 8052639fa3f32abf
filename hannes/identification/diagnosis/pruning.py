"""Pruning: which parameters of the effects named the recordings need; the others stay at off.

An effect with two sizes, such as compliance of leader and follower wires, may divide between them
what one of them did. Both are then far off. A size that reduces chi-squared by less than its price
is removed (Occam), unless the other could go as well. Then nothing decides between them, and both
stay with wide intervals.
"""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.gauss_newton import wald
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.profile_likelihood import held_at
from hannes.identification.diagnosis.score_test import amplitude_names
from hannes.identification.diagnosis.tuning import FIT, SEARCH


def pruned(point: Linearisation, effects: Sequence[str], variance_factor: float) -> Linearisation:
    """The fit with sizes of these effects held at off that reduce chi-squared too little.

    variance_factor: by which chi-squared is divided. At least one size of each effect stays.
    """
    space = point.space
    for name in effects:
        sizes = [space.place(each) for each in amplitude_names(space.effects[name])]
        places = [
            each for each in sizes if each in point.active
        ]  # only the first effect of a class is fitted
        while len(places) > 1 and (found := _without_one(point, places, variance_factor)):
            place, point = found
            places.remove(place)
    return point


def _without_one(
    point: Linearisation, places: Sequence[int], variance_factor: float
) -> tuple[int, Linearisation] | None:
    """The size that is missed least, and the fit without it; None where it stays.

    One that by the linearisation is missed much is tried without only where another may go.
    """
    surely = [k for k in places if wald(point, [k]) > SEARCH.surely_missed * variance_factor]
    if len(surely) == len(places):
        return None
    most = point.chi2 + (SEARCH.parameter_price + FIT.missed_more) * variance_factor
    fits = {k: _at_off(point, k, most) for k in places if k not in surely}
    if any(_rise(point, fit, variance_factor) <= SEARCH.parameter_price for fit in fits.values()):
        fits |= {k: _at_off(point, k, most) for k in surely}
    rises = {k: _rise(point, fits.get(k), variance_factor) for k in places}
    least, next_least = sorted(rises, key=lambda place: rises[place])[:2]
    fit = fits.get(least)
    if (
        fit is None
        or rises[least] > SEARCH.parameter_price
        or rises[next_least] < rises[least] + FIT.missed_more
    ):
        return None
    return least, fit


def _at_off(point: Linearisation, place: int, most: float) -> Linearisation | None:
    """The fit without one size; one that stays far above `most` is given up: it is missed."""
    return held_at(point, np.array([place]), np.zeros(1), most)


def _rise(point: Linearisation, fit: Linearisation | None, variance_factor: float) -> float:
    return np.inf if fit is None else (fit.chi2 - point.chi2) / variance_factor
