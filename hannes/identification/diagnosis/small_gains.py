"""Small gains, judged beside a baseline that started in the machine as given, parts and all.

A baseline is fitted before it is known what parts are off for themselves. Where recordings inform
much, it may so end in a local minimum, beside which an effect gains a little although nothing is
missing. Parts add up linearly in a fit, too, and what that neglects may gain as much.
"""

from dataclasses import replace

from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import Progress, started_at
from hannes.identification.diagnosis.parts_as_fitted import (
    differenced_about,
    leaves_noise,
    with_parts_as_fitted,
)
from hannes.identification.diagnosis.trials import SearchResult, Trial, best_first, priced
from hannes.identification.diagnosis.tuning import FIT, SEARCH, VERDICT


def with_small_gains(found: SearchResult, progress: Progress) -> SearchResult:
    """The result beside the lowest such baseline, its best effects refitted beside that.

    Unchanged where one gains much, where the baseline leaves more than noise, and where a machine
    has no like parts.
    """
    every = [*found.trials, *([found.generic] if found.generic else [])]
    most = max((each.delta_chi2 for each in every), default=0.0)
    near = leaves_noise(found.baseline, found.variance_factor)
    if not (near and VERDICT.doubt <= most < SEARCH.sure_beside and found.baseline.model.parts_at):
        return found
    progress("the baseline, from the machine as given with its parts")
    again = _from_as_given(found.baseline, found.variance_factor)
    if again is None or again.chi2 >= found.baseline.chi2:
        return found
    nominal = differenced_about(found.nominal, again.model)
    found = replace(found, baseline=again, nominal=nominal or found.nominal)
    generic = found.generic and _repriced(found, _beside(again, found.generic))
    return _judged(replace(found, generic=generic), progress)


def _from_as_given(point: Linearisation, variance_factor: float) -> Linearisation | None:
    """The fit from the machine as given, of which no part is off; None where that fails."""
    x = point.x.copy()
    x[point.space.uncertain] = 0.0
    there = differenced_about(replace(point, x=x), point.model.with_parts_at({}))
    return there and with_parts_as_fitted(fitted(there, FIT.steps_per_round), variance_factor)


def _judged(found: SearchResult, progress: Progress) -> SearchResult:
    """The effects that gain most refitted beside the baseline, until the best one is."""
    trials = best_first([_repriced(found, each) for each in found.trials])
    done: set[tuple[str, ...]] = set()
    while trials and trials[0].effects not in done and trials[0].delta_chi2 >= VERDICT.doubt:
        first, *rest = trials
        progress(f"{' and '.join(first.effects)}, beside that".replace("_", " "))
        done.add(first.effects)
        trials = best_first([_repriced(found, _beside(found.baseline, first)), *rest])
    return replace(found, trials=trials)


def _repriced(found: SearchResult, trial: Trial) -> Trial:
    return priced(found.baseline, trial, found.variance_factor)


def _beside(start: Linearisation, trial: Trial) -> Trial:
    """Its effects refitted from there on, at the sizes that they have; itself where that fails."""
    own = trial.point.space.of(*trial.effects)
    begun = started_at(start, own, trial.point.x[own])
    point = begun and with_parts_as_fitted(fitted(begun, FIT.steps_per_round))
    return trial if point is None else replace(trial, point=point)
