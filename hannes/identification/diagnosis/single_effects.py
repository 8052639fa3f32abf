"""Single effects beside one baseline: all are looked at, the likeliest fitted, the best refined."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.better_baseline import led_by_little
from hannes.identification.diagnosis.deepest_minimum import deepest_minimum
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.global_starts import (
    absorbed_by_baseline,
    fits_from_nominal,
)
from hannes.identification.diagnosis.like_faults import with_like_faults
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.multistart import (
    Fits,
    Progress,
    better,
    far_above,
    first_fits,
    fit_beside,
    predicted_at,
    refined,
)
from hannes.identification.diagnosis.noise_scale import estimated_variance_factor
from hannes.identification.diagnosis.reservations import ends_reached
from hannes.identification.diagnosis.score_test import Guess, in_place_of, screened
from hannes.identification.diagnosis.shape_rival import raises_no_doubt
from hannes.identification.diagnosis.shortlist import next_laws, shortlist
from hannes.identification.diagnosis.trials import (
    SearchResult,
    Trial,
    converged,
    priced,
    with_confusable,
)
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded
from hannes.plants.part_fault import like_faults


def looked_at(baseline: Linearisation, progress: Progress) -> list[Guess]:
    """What each effect promises beside a baseline, generic disturbances among them."""
    progress("a look at every effect")
    return screened(baseline, list(baseline.space.effects), SEARCH.near_sizes)


def promises_all(baseline: Linearisation, every: Sequence[Guess]) -> bool:
    """Whether the likeliest effect would leave little."""
    most = max((each.delta_chi2 for each in every if each.effect not in GENERIC), default=0.0)
    return baseline.chi2 - most < SEARCH.biased_baseline * baseline.residual.size


def searched_beside(
    baseline: Linearisation,
    given: AsGiven,
    known: Fits,
    progress: Progress,
    looked: Sequence[Guess] = (),
) -> SearchResult:
    """Single effects beside a baseline: screened, the best refitted.

    known: fits from elsewhere;  looked: what effects promise here, where that was asked before
    """
    nominal, every = given.nominal, looked or looked_at(baseline, progress)
    guesses = [each for each in every if each.effect not in GENERIC]
    fits, predicted = _begun(baseline, given, guesses, known, progress)
    fits = refined(nominal, baseline, fits, predicted, progress)
    led = led_by_little(baseline, fits, progress)
    if led.better is not None:
        return searched_beside(led.better, given, {**known, **fits}, progress)
    try:
        fits = _further(baseline, given, guesses, fits, progress)
        result, cut_short = _compared(baseline, given, every, fits, progress), False
    except SearchEnded:
        if not stands(baseline, fits):
            raise
        baseline.model.work.extended()
        baseline.model.work.extended_for_rivals()
        result, cut_short = _compared(baseline, given, every, fits, progress), True
    return replace(result, asked=led.by, cut_short=cut_short)


def stands(baseline: Linearisation, fits: Fits) -> bool:
    """Whether the best fit stands without more: it explains all, and no other part may have it."""
    best = min(fits, key=lambda name: fits[name].chi2, default="")
    if not best or like_faults(baseline.space.effects, best):
        return False
    biased = baseline.chi2 > SEARCH.biased_baseline * baseline.residual.size
    return biased and explains_all(baseline, fits[best])


def _further(
    baseline: Linearisation,
    given: AsGiven,
    guesses: Sequence[Guess],
    fits: Fits,
    progress: Progress,
) -> Fits:
    """The fits, with large starts where the best is at an end, and other minima of the best."""
    if _at_an_end(fits) and (starts := given.large([each.effect for each in guesses])):
        fits = first_fits(baseline, starts, fits, progress)
        fits = refined(given.nominal, baseline, fits, {}, progress)
    return _deepened(given.nominal, baseline, fits, progress)


def _compared(
    baseline: Linearisation,
    given: AsGiven,
    every: Sequence[Guess],
    fits: Fits,
    progress: Progress,
) -> SearchResult:
    """The fits as trials, the best first, with the best generic disturbance."""
    guesses = [each for each in every if each.effect not in GENERIC]
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
    known = given.nominal, baseline, guesses, confusable, None, None, variance_factor
    return SearchResult(*known, generic=generic)


def _begun(
    baseline: Linearisation,
    given: AsGiven,
    guesses: Sequence[Guess],
    known: Fits,
    progress: Progress,
) -> tuple[Fits, Mapping[str, float]]:
    """Best fit with each effect from every start, and the reduction that its guess predicts.

    Where the likeliest ones explain all, nothing is started in the machine as given.
    """
    likely = [(baseline, each) for each in shortlist(baseline, guesses)]
    likely = [start for start in likely if start[1].delta_chi2 > SEARCH.faint]
    starts, near = likely, known
    if promises_all(baseline, guesses):
        starts, near = [], first_fits(baseline, likely, known, progress)
        if any(explains_all(baseline, each) for each in near.values()):
            return near, predicted_at(baseline, likely)
    far = better(given.global_fits(baseline, progress), known)
    left = min((each.chi2 for each in better(near, far).values()), default=baseline.chi2)
    others = [guess for _, guess in likely if guess.effect not in far]
    fits = better(near, far | _absorbed(baseline, given, others, left, progress))
    if baseline.chi2 > SEARCH.biased_baseline * baseline.residual.size:
        starts = [*starts, *((baseline, each) for each in next_laws(baseline, guesses))]
        reached = far_above(baseline, min((e.chi2 for e in fits.values()), default=np.inf))
        if reached > baseline.chi2:
            starts += given.large([each.effect for each in guesses])
    return first_fits(baseline, starts, fits, progress), predicted_at(baseline, [*likely, *starts])


def explains_all(baseline: Linearisation, point: Linearisation) -> bool:
    """Whether a fit explains much and leaves less than noise as assumed, which is overstated."""
    much = baseline.chi2 - point.chi2 > SEARCH.slight
    return much and point.chi2 < SEARCH.explained * point.residual.size


def _absorbed(
    baseline: Linearisation,
    given: AsGiven,
    likely: Sequence[Guess],
    left: float,
    progress: Progress,
) -> Fits:
    """Fits in the machine as given of likely effects that the baseline absorbs.

    left: chi-squared that the best fit leaves by then
    """
    names = [
        guess.effect
        for guess in likely
        if guess.delta_chi2 >= SEARCH.hopeless * (baseline.chi2 - left)
        and absorbed_by_baseline(baseline, guess)
    ]
    return fits_from_nominal(given.nominal, baseline, names, progress, left)


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
    return _most_doubtful(found)


def _most_doubtful(found: Sequence[Trial]) -> Trial | None:
    """The best generic disturbance; of some as good as that the one of fewest numbers."""
    most = max((each.delta_chi2 for each in found), default=0.0)
    equal = [each for each in found if each.delta_chi2 >= most - SEARCH.rival]
    return min(equal, key=lambda each: each.numbers, default=None)


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
    beside = screened(best.point, list(promised))
    there = in_place_of(best.point, best.effects[0], beside)
    near = SEARCH.generic_reach * (baseline.chi2 - best.point.chi2)
    return {
        each.effect
        for each in beside
        if max(promised[each.effect], there[each.effect].delta_chi2) >= near
        and not raises_no_doubt(best, each)
    }


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
    return with_like_faults(nominal, baseline, fits, best, progress)
