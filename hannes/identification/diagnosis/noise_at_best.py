"""Noise estimated anew at the machine that the best effects lead to.

That is done where the baseline leaves far too much, and for an effect that has a phase.

Noise is estimated at the baseline: what sensor noise makes the machine do, how runs and like parts
differ. A baseline that takes a large missing effect upon itself is no machine that there is. Noise
at it hides what a smaller effect does, and stands out by itself.
"""

from dataclasses import replace

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis.baseline import FINE, lost
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance, estimated_noise
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.part_deviations import part_deviations
from hannes.identification.diagnosis.trials import (
    Joint,
    SearchResult,
    Trial,
    best_first,
    priced,
)
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded


def waits(found: SearchResult) -> bool:
    """Whether noise is estimated anew once further effects are found.

    Where the baseline is lost, noise is that of the machine as given. A machine whose best effect
    leaves far too much lacks others.
    """
    best = found.best
    much = SEARCH.lost_baseline * found.bins
    return best is not None and lost(found.baseline) and best.point.chi2 > much


def has_phase(trial: Trial) -> bool:
    """Whether one of its effects has a phase: then sampling changes its signature with that.

    No correction by its size alone is made, so that noise anew stands in for one.
    """
    known = trial.point.space.effects
    return any(known[name].has_phase for name in trial.effects)


def with_noise_at_best(found: SearchResult, seed: int, progress: Progress) -> SearchResult:
    """The result with its noise estimated at the best trial; unchanged where that is not needed.

    Once more where it has a phase, as the fit moves that. Where the bound of work ends that, the
    first one stands. What is lost without each of several effects held for the old noise, and is
    dropped.
    """
    best = found.best
    if best is None or not (_lost(found, best.point) or has_phase(best)):
        return found
    for number in range(1 + has_phase(best)):
        progress("noise, at the machine found")
        try:
            found = _in_noise(found, best, _noise_at(best.point, seed))
        except ComputationFailed:
            break
        except SearchEnded:
            if not number:
                raise
            return replace(found, cut_short=True)
        best = found.best or best
    return found


def _in_noise(found: SearchResult, best: Trial, noise: NoiseCovariance) -> SearchResult:
    """The result in other noise: the best effects refitted, and singles that are their rivals."""
    nominal, baseline = (with_noise(each, noise) for each in (found.nominal, found.baseline))
    if not lost(found.baseline):
        baseline = settled(fitted(baseline, FIT.steps_per_round))
    far = SEARCH.further_from_best * best.point.chi2
    points = [_again(each.point, noise, far) for each in found.trials]
    several = found.joint and _again(found.joint.trial.point, noise, far)
    known = [baseline, *points, *([several] if several else [])]
    variance_factor = estimated_variance_factor(baseline, min(each.chi2 for each in known))

    def again(trial: Trial, point: Linearisation) -> Trial:
        return priced(baseline, replace(trial, point=point), variance_factor)

    trials = [again(*each) for each in zip(found.trials, points, strict=True)]
    generic = found.generic and again(found.generic, _again(found.generic.point, noise, far))
    return replace(
        found,
        nominal=nominal,
        baseline=baseline,
        trials=best_first([each for each in trials if each.point.chi2 < baseline.chi2]),
        joint=Joint(again(found.joint.trial, several)) if found.joint and several else None,
        generic=generic,
        variance_factor=variance_factor,
    )


def _lost(found: SearchResult, best: Linearisation) -> bool:
    """Whether the baseline leaves far too much, and the best effect most of that not, yet some."""
    bins, baseline = found.bins, found.baseline.chi2
    return (
        baseline > SEARCH.lost_baseline * bins
        and SEARCH.biased_baseline * bins < best.chi2 < SEARCH.found_again * baseline
    )


def _noise_at(point: Linearisation, seed: int) -> NoiseCovariance:
    """Noise of the machine at a point, its effects a part of it."""
    model = point.model
    machine = model.as_machine()
    parts = part_deviations(machine, point.x)
    return replace(estimated_noise(machine, point.x, FINE, seed, parts), model=model)


def _again(point: Linearisation, noise: NoiseCovariance, far: float) -> Linearisation:
    """The fit under other noise; one that left more than `far` is not refitted."""
    there = with_noise(point, noise)
    return settled(fitted(there, 4)) if point.chi2 < far else there
