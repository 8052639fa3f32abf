"""Small gains, judged with the machine's parts as each fit has them off for themselves.

Where a fit leaves noise, a small gain may be what the fit neglects: parts add up linearly in it.
"""

from dataclasses import replace

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.parts_as_fitted import leaves_noise, with_parts_as_fitted
from hannes.identification.diagnosis.trials import SearchResult, Trial, best_first
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT


def gain_of_parts(fewer: Linearisation, more: Linearisation, variance_factor: float) -> float:
    """How much of one fit's gain over another is gone with parts as each has them; at least 0."""
    if not leaves_noise(fewer):
        return 0.0
    try:
        least = [with_parts_as_fitted(each, variance_factor).chi2 for each in (fewer, more)]
    except ComputationFailed:
        return 0.0
    less = (fewer.chi2 - more.chi2) - (least[0] - least[1])
    return max(0.0, less) / variance_factor


def with_small_gains(found: SearchResult, progress: Progress) -> SearchResult:
    """The result with small gains less what parts explain; unchanged where one gains much."""
    every = [*found.trials, *([found.generic] if found.generic else [])]
    most = max((each.delta_chi2 for each in every), default=0.0)
    if not VERDICT.doubt <= most < SEARCH.sure_beside or not leaves_noise(found.baseline):
        return found
    progress("small gains, with parts as each fit has them")
    first = [_judged(found, each) for each in found.trials[: SEARCH.small_gains]]
    generic = found.generic and _judged(found, found.generic)
    trials = best_first([*first, *found.trials[SEARCH.small_gains :]])
    return replace(found, trials=trials, generic=generic)


def _judged(found: SearchResult, trial: Trial) -> Trial:
    if trial.delta_chi2 < VERDICT.doubt:
        return trial
    less = gain_of_parts(found.baseline, trial.point, found.variance_factor)
    return replace(trial, delta_chi2=trial.delta_chi2 - less)
