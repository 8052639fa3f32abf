"""The best fault of a part, tried in every other like part: recordings may not separate these."""

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Fits, Progress, negligible
from hannes.plants.part_fault import like_faults


def with_like_faults(baseline: Linearisation, fits: Fits, best: str, progress: Progress) -> Fits:
    """The fits with that of the best one tried in the other parts, as large as it is in its own."""
    found, leader = dict(fits), fits[best]
    for name in like_faults(baseline.space.effects, best):
        progress(f"{name.replace('_', ' ')}, as {best.replace('_', ' ')}")
        point = _transferred(baseline, leader, best, name)
        if point is not None and point.chi2 < min(
            baseline.chi2, found[name].chi2 if name in found else np.inf
        ):
            found[name] = point
    return found


def _transferred(
    baseline: Linearisation, leader: Linearisation, best: str, name: str
) -> Linearisation | None:
    """A fit of one fault from the machine and the size of another."""
    space, x = leader.space, leader.x.copy()
    own, other = space.of(name), space.of(best)
    x[own], x[other] = leader.x[other], 0.0
    active = np.union1d(np.setdiff1d(leader.active, other), own)
    start = leader.with_active(active).moved(x, np.sort(own))
    if start is None:
        return None
    return settled(fitted(start, 4), negligible(baseline.chi2 - leader.chi2), leader.chi2)
