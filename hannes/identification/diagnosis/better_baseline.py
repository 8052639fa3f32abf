"""The baseline refitted from where an effect led: chi-squared may have a lower minimum there."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hannes.identification.diagnosis.baseline import lost
from hannes.identification.diagnosis.gauss_newton import fitted, relinearised, settled
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Fits, Progress, negligible, without
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.tuning import FIT, SEARCH

NONE_FRESH = np.zeros(0, int)  # no derivatives anew


def better_baseline(
    baseline: Linearisation,
    best: Linearisation,
    effects: Sequence[str],
    variance_factor: float,
    progress: Progress,
) -> Linearisation | None:
    """The baseline refitted from the best fit, without its effects; None where it is no better.

    With contacts chi-squared has several local minima. An effect may only have led out of one. The
    machine's own parameters take over as much of its work as they can. One that is lost is none.
    """
    progress("the baseline from there")
    rows = without(best, effects)
    point = baseline.moved(rows[np.argmin(baseline.chi2_at(rows))], NONE_FRESH)
    if point is None:
        return None
    point = fitted(relinearised(point), FIT.steps_per_round)
    if lost(point):
        return None
    little = negligible(baseline.chi2 - best.chi2)
    point = settled(point, little, baseline.chi2)
    better = baseline.chi2 - point.chi2 > max(SEARCH.other_minimum * variance_factor, little)
    return point if better else None


class Led(NamedTuple):
    """A better baseline, and the fit that led there, or was asked in vain; None where none was."""

    better: Linearisation | None = None
    by: Linearisation | None = None


def led_by_little(baseline: Linearisation, fits: Fits, progress: Progress) -> Led:
    """A better baseline from where the best fit led, if that improves the baseline little.

    Most hands that miss nothing end here: asked before faults of other parts, that takes less.
    """
    best = min(fits, key=lambda name: fits[name].chi2, default=None)
    if best is None or not SEARCH.faint < baseline.chi2 - fits[best].chi2 < SEARCH.slight:
        return Led()
    point, variance_factor = fits[best], estimated_variance_factor(baseline, fits[best].chi2)
    return Led(better_baseline(baseline, point, [best], variance_factor, progress), point)
