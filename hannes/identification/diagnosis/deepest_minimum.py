"""The deepest minimum around a fit with a size-dependent effect: there are many local ones."""

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.global_starts import size_dependent
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import started_at
from hannes.identification.diagnosis.score_test import amplitude_names
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import part_faults


def deepest_minimum(nominal: Linearisation, point: Linearisation, name: str) -> Linearisation:
    """The best fit around one with a size-dependent effect: there are many local minima.

    Where more is missing, a minimum that is deeper by a small share of what is left is no other.
    """
    if not size_dependent(nominal, [name]) or part_faults(nominal.space.effects, [name]):
        return point
    own = nominal.space.of(name)
    for _ in range(SEARCH.neighbour_rounds):
        starts = (
            started_at(nominal, own, _resized(point, name, share)[own])
            for share in SEARCH.neighbour_sizes
        )
        fits = [fitted(each, SEARCH.further_steps) for each in starts if each is not None]
        nearest = min(fits, key=lambda each: each.chi2, default=point)
        best = settled(nearest, below=point.chi2)
        deeper = max(SEARCH.deeper, SEARCH.deeper_share * (point.chi2 - point.residual.size))
        found, point = point.chi2 - best.chi2, min(point, best, key=lambda each: each.chi2)
        if found < deeper:
            break
    return point


def _resized(point: Linearisation, name: str, share: float) -> np.ndarray:
    """x with an effect `share` times as large within its range, shape parameters kept, (size,)."""
    space, x = point.space, point.x.copy()
    places = [space.place(each) for each in amplitude_names(space.effects[name])]
    x[places] = np.clip(share * x[places], space.low[places], space.high[places])
    return x
