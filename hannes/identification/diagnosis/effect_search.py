"""Searches for what is missing: baseline, shortlist of single effects, then further ones."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.effect import Effect
from hannes.identification.diagnosis.baseline import based, lost
from hannes.identification.diagnosis.further_effects import with_further_effects
from hannes.identification.diagnosis.gauss_newton import fitted, relinearised, settled
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.global_starts import (
    absorbed_by_baseline,
    deepest_minimum,
    fits_from_nominal,
    global_fits,
    promised,
)
from hannes.identification.diagnosis.like_faults import with_like_faults
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Fits,
    Progress,
    far_above,
    fit_beside,
    negligible,
    refitted,
    without,
)
from hannes.identification.diagnosis.noise_at_best import with_noise_at_best
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.reservations import ends_reached
from hannes.identification.diagnosis.score_test import Guess, in_place_of, screened
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.shortlist import AsGiven, next_laws, shortlist
from hannes.identification.diagnosis.trials import (
    SearchResult,
    Trial,
    converged,
    may_be_named,
    priced,
    with_confusable,
)
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded, Work
from hannes.plants.protocol import Plant


def search_effects(
    plant: Plant,
    entries: Sequence[Entry],
    effects: Sequence[Effect],
    settings: Settings,
    seed: int,
    progress: Progress = lambda text: None,
    work: Work | None = None,
) -> SearchResult:
    """Search for what is missing; ComputationFailed where the baseline cannot be simulated.

    work: what was spent before, and the limit of all
    """
    work = work or Work(bounded=True)
    groups = grouped(plant, entries)
    nominal, baseline = based(plant, groups, settings, effects, seed, progress, work)
    try:
        return _all_searched(nominal, baseline, effects, seed, progress)
    except SearchEnded:
        return SearchResult(nominal, baseline, [], [], None, None, 1.0, ended=work.ended)


def _all_searched(
    nominal: Linearisation,
    baseline: Linearisation,
    effects: Sequence[Effect],
    seed: int,
    progress: Progress,
) -> SearchResult:
    """Single effects beside the best baseline, then further ones."""
    names = [each.name for each in effects if each.name not in GENERIC]
    given = AsGiven(nominal, promised(nominal, baseline, names))
    known = global_fits(nominal, baseline, names, progress, given.promised)
    found = _searched(given, _beside_best(baseline, known), known, progress)
    found = _beside_better(given, found, known, progress)
    if baseline.chi2 < found.baseline.chi2:
        found = _rebased(found, baseline)
    return found if found.cut_short else _with_further(found, seed, progress)


def _beside_better(
    given: AsGiven, found: SearchResult, known: Fits, progress: Progress
) -> SearchResult:
    """The result beside the baseline that its best effect leads to, where that is a better one.

    Searched again while it is much better. Where the bound of work ends that, the fits of the
    search before stand beside it.
    """
    led = np.zeros(0)
    try:
        while (leader := _leading(found)) and not np.array_equal(leader.point.x, led):
            better = _back(found.baseline, leader, found.variance_factor, progress)
            if better is None:
                break
            led, less = leader.point.x, found.baseline.chi2 - better.chi2
            fits = {each.effects[0]: each.point for each in found.trials}
            found = _rebased(found, better)
            if less < SEARCH.second_share * leader.delta_chi2 * found.variance_factor:
                break
            found = _searched(given, better, {**known, **fits}, progress)
    except SearchEnded:
        if not led.size or not may_be_named(found):
            raise
        found.baseline.model.work.extended()
        return replace(found, cut_short=True)
    return found


def _beside_best(baseline: Linearisation, known: Fits) -> Linearisation:
    """The baseline; where it is lost, the machine of the best global fit, without its effect."""
    best = min(known.items(), key=lambda each: each[1].chi2, default=None)
    if best is None or not lost(baseline):
        return baseline
    return baseline.moved(without(best[1], [best[0]])[0], baseline.active) or baseline


def _with_further(found: SearchResult, seed: int, progress: Progress) -> SearchResult:
    """With further effects; single ones alone where the bound of work ends that search.

    What judges and closes them then has some work of its own.
    """
    try:
        found = with_noise_at_best(found, seed, progress)
        return with_further_effects(found, progress) if may_be_named(found) else found
    except SearchEnded:
        found.baseline.model.work.extended()
        return replace(found, cut_short=True)


def _leading(found: SearchResult) -> Trial | None:
    """The trial that improved the fit most: one that may be named, else any."""
    every = [*found.trials[:1], *([found.generic] if found.generic else [])]
    named = found.trials[:1] if may_be_named(found) else every
    best = max(named, key=lambda each: each.delta_chi2, default=None)
    return best if best is not None and best.delta_chi2 > SEARCH.faint else None


def _searched(
    given: AsGiven, baseline: Linearisation, known: Fits, progress: Progress
) -> SearchResult:
    """Single effects beside a baseline: screened, the best refitted; known: global fits."""
    nominal = given.nominal
    progress("a look at every effect")
    every = screened(baseline, list(baseline.space.effects), SEARCH.near_sizes)
    guesses = [each for each in every if each.effect not in GENERIC]
    names = [each.effect for each in guesses]
    likely = [guess for guess in shortlist(baseline, guesses) if guess.delta_chi2 > SEARCH.faint]
    reached = baseline.chi2 - min((each.chi2 for each in known.values()), default=baseline.chi2)
    absorbed = [
        g.effect
        for g in likely
        if g.effect not in known
        and g.delta_chi2 >= SEARCH.hopeless * reached
        and absorbed_by_baseline(baseline, g)
    ]
    known = {**known, **fits_from_nominal(nominal, baseline, absorbed, progress)}
    starts = [(baseline, guess) for guess in likely]
    biased = baseline.chi2 > SEARCH.biased_baseline * baseline.residual.size
    if biased:
        starts += [(baseline, guess) for guess in next_laws(baseline, guesses)]
        reached = far_above(baseline, min((e.chi2 for e in known.values()), default=np.inf))
        starts += given.large(names) if reached > baseline.chi2 else []
    fits = refitted(nominal, baseline, starts, known, SEARCH.name_limit, progress)
    if not biased and _at_an_end(fits) and (starts := given.large(names)):
        fits = refitted(nominal, baseline, starts, fits, SEARCH.name_limit, progress)
    fits = _deepened(nominal, baseline, fits, progress)
    variance_factor = estimated_variance_factor(
        baseline, min([baseline.chi2, *(each.chi2 for each in fits.values())])
    )
    trials = [
        priced(baseline, Trial((name,), point, 0.0), variance_factor)
        for name, point in fits.items()
    ]
    trials.sort(key=lambda each: -each.delta_chi2)
    if trials and trials[0].delta_chi2 > SEARCH.name_limit:
        trials[0] = converged(baseline, trials[0], variance_factor)
    confusable = with_confusable(baseline, guesses, trials)
    free = [each for each in every if each.effect in GENERIC]
    generic = _generic(baseline, free, trials, variance_factor, progress)
    return SearchResult(
        nominal, baseline, guesses, confusable, None, None, variance_factor, generic=generic
    )


def _leaves_much(point: Linearisation) -> bool:
    return point.chi2 > SEARCH.lost_baseline * point.residual.size


def _at_an_end(fits: Fits) -> bool:
    """Whether the best fit is at an end of its effect's range: others may be as large."""
    best = min(fits, key=lambda name: fits[name].chi2, default=None)
    return best is not None and bool(ends_reached(fits[best], (best,)))


def _generic(
    baseline: Linearisation,
    guesses: Sequence[Guess],
    trials: Sequence[Trial],
    variance_factor: float,
    progress: Progress,
) -> Trial | None:
    """The best generic disturbance, each fitted where its guess promises a reduction.

    Fitted from the baseline and from the machine of the best effect, after all effects: a machine
    that is biased by a generic disturbance is no start for an effect.
    """
    best = trials[0] if trials and trials[0].delta_chi2 > SEARCH.faint else None
    worth = _promising(baseline, guesses, best, variance_factor)
    found = []
    for guess in guesses:
        if guess.effect in worth:
            progress(guess.effect.replace("_", " "))
            point = fit_beside(baseline, guess, best.point if best else None)
            found += (
                [priced(baseline, Trial((guess.effect,), point, 0.0), variance_factor)]
                if point
                else []
            )
    return max(found, key=lambda each: each.delta_chi2, default=None)


def _promising(
    baseline: Linearisation, guesses: Sequence[Guess], best: Trial | None, variance_factor: float
) -> set[str]:
    """The generic disturbances whose guess promises a reduction, and one near the best effect's.

    Predicted at the baseline, and in the place of the best effect, where no machine is biased.
    """
    least = SEARCH.faint * variance_factor
    promised = {each.effect: each.delta_chi2 for each in guesses if each.delta_chi2 >= least}
    if best is None or not promised:
        return set(promised)
    there = in_place_of(best.point, best.effects[0], screened(best.point, list(promised)))
    near = SEARCH.generic_reach * (baseline.chi2 - best.point.chi2)
    return {name for name, value in promised.items() if max(value, there[name].delta_chi2) >= near}


def _back(
    baseline: Linearisation, best: Trial, variance_factor: float, progress: Progress
) -> Linearisation | None:
    """The baseline refitted from where the best effect led, without it; None where it is no better.

    With contacts chi-squared has several local minima. An effect may only have led out of one. The
    machine's own parameters take over as much of its work as they can. One that is lost is none.
    """
    progress("the baseline from there")
    rows = without(best.point, best.effects)
    point = baseline.moved(rows[np.argmin(baseline.chi2_at(rows))], baseline.active)
    if point is None:
        return None
    point = fitted(relinearised(point), FIT.steps_per_round)
    if lost(point):
        return None
    point = settled(point, negligible(baseline.chi2 - best.point.chi2), baseline.chi2)
    better = baseline.chi2 - point.chi2 > SEARCH.other_minimum * variance_factor
    return settled(point) if better else None


def _rebased(found: SearchResult, baseline: Linearisation) -> SearchResult:
    """The same result beside a better baseline: every reduction shrinks by that."""
    less = (found.baseline.chi2 - baseline.chi2) / found.variance_factor
    trials = [
        replace(each, delta_chi2=each.delta_chi2 - less)
        for each in found.trials
        if each.point.chi2 < baseline.chi2
    ]
    generic = found.generic and replace(found.generic, delta_chi2=found.generic.delta_chi2 - less)
    return replace(found, baseline=baseline, trials=trials, generic=generic)


def _deepened(
    nominal: Linearisation, baseline: Linearisation, fits: Fits, progress: Progress
) -> Fits:
    """The fits with the best one refitted around its size, if its signature depends on size.

    Not where it leaves much: what else is missing decides there which minimum is deepest.
    """
    best = min(fits, key=lambda name: fits[name].chi2, default=None)
    if best is None or fits[best].chi2 > baseline.chi2 - SEARCH.name_limit:
        return fits
    if not _leaves_much(fits[best]):
        progress(f"{best.replace('_', ' ')}, from about there")
        fits = {**fits, best: deepest_minimum(nominal, fits[best], best)}
    return with_like_faults(baseline, fits, best, progress)
