"""Small gains, judged beside baselines from no part off: as given, and where an effect led.

A baseline is fitted before it is known what parts are off for themselves. Where recordings inform
much, it may so end in a local minimum, beside which an effect gains a little although nothing is
missing. Parts add up linearly in a fit, too, and what that neglects may gain as much.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Progress,
    started_at,
    with_correction_at_size,
)
from hannes.identification.diagnosis.parts_as_fitted import (
    about,
    differenced_about,
    leaves_noise,
    with_parts_as_fitted,
)
from hannes.identification.diagnosis.trials import SearchResult, Trial, best_first, near, priced
from hannes.identification.diagnosis.tuning import FIT, SEARCH, VERDICT
from hannes.identification.diagnosis.work_bound import SearchEnded


def with_small_gains(found: SearchResult, progress: Progress) -> SearchResult:
    """The result beside the lowest such baseline, its best effects refitted beside that.

    Unchanged where one gains much, where the baseline leaves more than noise, and where no part of
    the machine was moved.
    """
    if not _gain_little(found) or not _moved(found.baseline):
        return found
    progress("the baseline, from the machine as given with its parts")
    given = np.zeros(found.baseline.space.uncertain.size)
    found = _beside_lower(found, given, progress)
    try:
        return _beside_where_it_led(found, progress)
    except SearchEnded:  # what stands beside the first one stands all the same
        return found


def _gain_little(found: SearchResult) -> bool:
    """Whether what gains most gains enough for a doubt, and no more than a baseline may cost."""
    every = [*found.trials, *([found.generic] if found.generic else [])]
    most = max((each.delta_chi2 for each in every), default=0.0)
    return VERDICT.doubt <= most < SEARCH.sure_beside


def _beside_where_it_led(found: SearchResult, progress: Progress) -> SearchResult:
    """The same once more from the machine of the best effect, without it, if it still gains."""
    best = next((each for each in found.trials[:1] if each.delta_chi2 >= VERDICT.doubt), None)
    if best is None:
        return found
    progress("the baseline, from there with its parts")
    return _beside_lower(found, best.point.x[found.baseline.space.uncertain], progress)


def _beside_lower(found: SearchResult, start: np.ndarray, progress: Progress) -> SearchResult:
    """The effects judged beside the baseline that starts there; unchanged if that is no lower.

    start: values of the machine
    """
    again = _from_no_parts(found.baseline, start, found.variance_factor)
    if again is None or again.chi2 >= found.baseline.chi2:
        return found
    nominal = about(found.nominal, again.noise)
    if nominal is None:
        return found
    return _judged(found, replace(found, baseline=again, nominal=nominal), progress)


def _moved(baseline: Linearisation) -> bool:
    """Whether parts are where the baseline has them, which is so where it left noise."""
    return bool(baseline.model.parts_at) and leaves_noise(baseline)


def _from_no_parts(
    point: Linearisation, start: np.ndarray, variance_factor: float
) -> Linearisation | None:
    """The fit from values of the machine, of which no part is off; None where that fails."""
    x = point.x.copy()
    x[point.space.uncertain] = start
    there = differenced_about(replace(point, x=x), point.model.with_parts_at({}))
    return there and with_parts_as_fitted(fitted(there, FIT.steps_per_round), variance_factor)


def _judged(before: SearchResult, found: SearchResult, progress: Progress) -> SearchResult:
    """The effects refitted beside the baseline: the best one until it is, and its rivals before.

    Where the bound of work ends that, each with its fit before.
    """
    rivals = [t.effects for first in before.trials[:1] for t in near(first, before.trials)]
    generic = found.generic and _repriced(found, found.generic)
    trials = best_first([_repriced(found, each) for each in found.trials])
    done: list[tuple[str, ...]] = []
    try:
        generic = generic and _repriced(found, _beside(found, generic))
        while (one := _next(trials, rivals, done)) is not None:
            progress(f"{' and '.join(one.effects)}, beside that".replace("_", " "))
            done.append(one.effects)
            rest = [each for each in trials if each is not one]
            trials = best_first([_repriced(found, _beside(found, one)), *rest])
    except SearchEnded:  # the lower baseline stands all the same
        pass
    return replace(found, trials=trials, generic=generic)


def _next(
    trials: Sequence[Trial], rivals: Sequence[tuple[str, ...]], done: Sequence[tuple[str, ...]]
) -> Trial | None:
    """The trial to be refitted next; None where nothing gains enough, or all that may have been."""
    if not trials or trials[0].delta_chi2 < VERDICT.doubt:
        return None
    wanted = [trials[0].effects, *rivals]
    return next((t for t in trials if t.effects in wanted and t.effects not in done), None)


def _repriced(found: SearchResult, trial: Trial) -> Trial:
    return priced(found.baseline, trial, found.variance_factor)


def _beside(found: SearchResult, trial: Trial) -> Trial:
    """Its effects refitted beside the baseline, from its values and from those of its fit."""
    base, own = found.baseline, trial.point.space.of(*trial.effects)
    begun = [started_at(base, own, trial.point.x[own]), about(trial.point, base.noise)]
    fits = [fitted(each, FIT.steps_per_round) for each in begun if each is not None]
    if not fits:
        return trial
    point = min(fits, key=lambda each: each.chi2)
    for name in trial.effects:
        point = with_correction_at_size(point, name)
    return replace(trial, point=with_parts_as_fitted(point, found.variance_factor) or point)
