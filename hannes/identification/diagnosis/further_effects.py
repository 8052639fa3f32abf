"""As many effects as there are: one after another, together, and in the machine as given."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from hannes.identification.diagnosis.effect_removal import pruned_effects, with_rivals
from hannes.identification.diagnosis.forward_selection import leaves_much, selected
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.joint_starts import started_together
from hannes.identification.diagnosis.multistart import Progress
from hannes.identification.diagnosis.noise_at_best import (
    has_phase,
    waits,
    with_noise_at_best,
)
from hannes.identification.diagnosis.reservations import beyond_noise, far_from_prior
from hannes.identification.diagnosis.score_test import screened_widely
from hannes.identification.diagnosis.sets_as_given import (
    enlarged_as_given,
    restarted,
    surely_there,
)
from hannes.identification.diagnosis.trials import (
    Joint,
    SearchResult,
    Trial,
    priced,
    scaled,
)
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded


def with_further_effects(found: SearchResult, seed: int, progress: Progress) -> SearchResult:
    """Look for further effects beside the best one, and for what is left after the last.

    Where the bound of work ends that, what was found by then stands, with what could stand in for
    it: that has some work of its own. Without that nothing stands but single effects.
    """
    best = selected(found, Joint(found.trials[0]), progress, until=partial(_met_phase, found))
    try:
        before = best
        if not best.cut_short and (waits(found) or _met_phase(found, best)):
            best = _in_their_noise(best, seed, progress)
        best = best if best.cut_short else _with_sets(best, progress)
        best = best if best.cut_short else _from_as_given(best, progress)
        if not best.cut_short and _met_phase(before, best):
            best = _in_their_noise(best, seed, progress)
        if not best.cut_short:
            return with_rivals(best, progress)
    except SearchEnded:
        best = replace(best, cut_short=True)
    best.baseline.model.work.extended_for_rivals()
    return with_rivals(best, progress)


def _met_phase(before: SearchResult, found: SearchResult) -> bool:
    """Whether an effect with a phase is among the best ones, and was not among those before."""
    new, old = (each.best is not None and has_phase(each.best) for each in (found, before))
    return new and not old


def _in_their_noise(best: SearchResult, seed: int, progress: Progress) -> SearchResult:
    """The result in the noise of the machine with its effects, and what else is found in that.

    Where there is no such noise, a selection that a phase broke off goes on all the same. Where the
    bound of work ends that, what is lost without each effect is known in the old noise alone.
    """
    found = with_noise_at_best(best, seed, progress)
    if best.best is None or found.cut_short:
        return replace(best, cut_short=found.cut_short)
    if found is best or found.best is None:
        go_on = has_phase(best.best)
        return selected(best, best.joint or Joint(best.best), progress) if go_on else best
    joint = pruned_effects(found, found.joint or Joint(found.best), progress)
    return selected(found, joint, progress)


def _with_sets(best: SearchResult, progress: Progress) -> SearchResult:
    """The result or, where it leaves less, that of several effects started together."""
    try:
        for trial in _together(best, progress):
            start = scaled(best, trial.point)
            known = priced(start.baseline, trial, start.variance_factor)
            best = _better(best, trial, progress)
            if best.cut_short or not leaves_much(start, known):
                break
    except SearchEnded:
        return replace(best, cut_short=True)
    return best


def _better(
    best: SearchResult, trial: Trial, progress: Progress, least: float = SEARCH.name_limit
) -> SearchResult:
    """The result or, where it leaves less, that of a search which goes on from other effects.

    least: by how much less
    """
    start = scaled(best, trial.point)
    joint = Joint(priced(start.baseline, trial, start.variance_factor))
    pruned = pruned_effects(start, joint, progress)
    if pruned.trial.point.chi2 >= _left(best) and len(pruned.trial.effects) == 1:
        return best
    other = selected(start, pruned, progress)
    better = _left(other) < _left(best) - least
    return replace(other if better else best, cut_short=best.cut_short or other.cut_short)


def _from_as_given(best: SearchResult, progress: Progress) -> SearchResult:
    """The result or, where it leaves less, what its effects lead to from the machine as given.

    Where something more is there, the machine found is biased by it, and shows it no more.
    """
    met = set[frozenset[str]]()
    try:
        while not best.cut_short and (trial := best.best) and _effects(best) not in met:
            met.add(_effects(best))
            if not _lacks(best, trial):
                break
            again = restarted(best, trial, progress)
            if again is not None and again.point.chi2 < _left(best) - SEARCH.deeper:
                best = _better(best, again, progress, SEARCH.deeper)
            if best.cut_short or _effects(best) != frozenset(trial.effects):
                continue
            for other in _enlarged_as_given(best, progress):
                best = _better(best, other, progress)
                if best.cut_short or _effects(best) != frozenset(trial.effects):
                    break
    except SearchEnded:
        return replace(best, cut_short=True)
    return best


def _effects(found: SearchResult) -> frozenset[str]:
    return frozenset(found.best.effects) if found.best else frozenset()


def _lacks(found: SearchResult, trial: Trial) -> bool:
    """Whether effects leave more than noise, or take an improbable machine."""
    return bool(beyond_noise(trial.point, found.bins)) or far_from_prior(trial) is not None


def _enlarged_as_given(found: SearchResult, progress: Progress) -> Iterator[Trial]:
    """The effects that are surely there with those that enter beside them, the likeliest first."""
    if found.best is not None and _lacks(found, found.best):
        names = surely_there(found.joint) if found.joint else found.best.effects
        yield from enlarged_as_given(found, names, found.best.point, progress)


def _left(found: SearchResult) -> float:
    return found.best.point.chi2 if found.best else found.baseline.chi2


def _together(found: SearchResult, progress: Progress) -> Iterator[Trial]:
    """Several effects started together, where the best ones leave much."""
    if found.best is None or not leaves_much(found, found.best):
        return
    left, lowered = _left(found) - found.bins, found.baseline.chi2 - _left(found)
    if left < SEARCH.much_left * lowered:
        return
    progress("all effects together")
    names = [name for name in found.baseline.space.effects if name not in GENERIC]
    points = [(each, screened_widely(each, names)) for each in (found.nominal, found.baseline)]
    for effects, point in started_together(points, progress):
        yield Trial(effects, point, 0.0)
