"""Forward selection with backward elimination: one more effect after another beside some.

After each further effect every other one is removed again, and stays only where it is missed.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.effect_removal import pruned_effects
from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.global_starts import (
    absorbed_by_baseline,
    fits_from_nominal,
    global_fits,
)
from hannes.identification.diagnosis.like_faults import varied
from hannes.identification.diagnosis.multistart import (
    Progress,
    started_as_given,
    started_at_guess,
    with_correction_at_size,
)
from hannes.identification.diagnosis.reservations import far_from_prior
from hannes.identification.diagnosis.score_test import SMALL, Guess, screened_widely
from hannes.identification.diagnosis.trials import (
    Joint,
    SearchResult,
    Trial,
    best_first,
    converged,
    needed_beside,
    priced,
    scaled,
    with_confusable,
)
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded


def leaves_much(found: SearchResult, trial: Trial) -> bool:
    """Whether a fit leaves more than a complete model does, and enough for one more effect."""
    chi2, bins = trial.point.chi2, trial.point.residual.size
    wrong = needed_beside(trial, found.variance_factor) * found.variance_factor
    return chi2 > max(SEARCH.biased_baseline * bins, bins + wrong)


def selected(
    found: SearchResult,
    joint: Joint,
    progress: Progress,
    until: Callable[[SearchResult], bool] = lambda result: False,
) -> SearchResult:
    """One more effect after another, each time without those that are not missed any more.

    Where the bound of work ends that, with those that were found by then.

    until: whether a result is the last one
    """
    result = _with(found, joint, None)
    try:
        for further in _selections(found, joint, progress):
            result = further
            if until(result):
                break
    except SearchEnded:
        return replace(result, cut_short=True)
    return result


def _selections(found: SearchResult, joint: Joint, progress: Progress) -> Iterator[SearchResult]:
    """The result after each further effect; one that does not stay is not tried again there."""
    met: dict[frozenset[str], float] = {}
    refused: dict[frozenset[str], set[str]] = {}
    added: set[tuple[frozenset[str], str]] = set()
    while True:
        best, effects = joint.trial, frozenset(joint.trial.effects)
        progress("what is left")
        away = refused.get(effects, set())
        guesses = _others(found, best)
        yield _with(found, joint, guesses[0] if guesses else None)
        again = best.delta_chi2 < met.get(effects, -np.inf) + SEARCH.name_limit
        more = not again or (leaves_much(found, best) and 0 < len(away) <= SEARCH.refused_effects)
        if not more or len(effects) == SEARCH.most_effects:
            return
        met[effects] = max(best.delta_chi2, met.get(effects, -np.inf))
        tried = [each for each in guesses if each.effect not in away]
        larger = _enlarged(found, best, tried, progress)
        needed = needed_beside(best, found.variance_factor)
        if not larger or larger[0].delta_chi2 - best.delta_chi2 < needed:
            yield _with(found, joint, _refuted(best, guesses, larger, found.variance_factor))
            return
        name = larger[0].effects[-1]
        if (effects, name) in added:
            refused.setdefault(effects, set()).add(name)
            continue
        added.add((effects, name))
        larger[0] = converged(found.baseline, larger[0], found.variance_factor)
        found = scaled(found, larger[0].point)
        joint = _pruned(found, best, larger, progress)
        yield _with(found, joint, None)
        if name not in joint.trial.effects:
            refused.setdefault(effects, set()).add(name)


def _pruned(found: SearchResult, best: Trial, larger: Sequence[Trial], progress: Progress) -> Joint:
    """The best of some larger sets of effects, without those that are not missed in it."""
    one, first, *others = (
        priced(found.baseline, each, found.variance_factor) for each in (best, *larger)
    )
    joint = Joint(first, {first.effects[-1]: one}, others=tuple(others))
    return pruned_effects(found, joint, progress)


def _with(found: SearchResult, joint: Joint, remaining: Guess | None) -> SearchResult:
    """The result with these effects; a single one is the first of the trials."""
    if len(joint.trial.effects) > 1:
        return replace(found, joint=joint, remaining=remaining)
    alone = with_confusable(found.baseline, found.guesses, [joint.trial])
    others = [each for each in found.trials if each.effects != joint.trial.effects]
    return replace(found, trials=[*alone, *others], joint=None, remaining=remaining)


def _refuted(
    best: Trial, guesses: list[Guess], larger: list[Trial], variance_factor: float
) -> Guess | None:
    """The best of what is left after some effects: refits where there are any, else guesses.

    larger: best first
    """
    reductions = {
        each.effects[-1]: (each.delta_chi2 - best.delta_chi2) * variance_factor
        for each in reversed(larger)
    }
    remaining = [
        replace(g, delta_chi2=reductions[g.effect], refitted=True) if g.effect in reductions else g
        for g in guesses
    ]
    return max(remaining, key=lambda each: each.delta_chi2, default=None)


def _enlarged(
    found: SearchResult, best: Trial, guesses: Sequence[Guess], progress: Progress
) -> list[Trial]:
    """One more effect beside some, all refitted, the best first."""
    needed = needed_beside(best, found.variance_factor)
    enough = [each for each in guesses if each.delta_chi2 >= needed * found.variance_factor]
    larger: list[Trial] = []
    for guess in varied(best.point.space.effects, enough)[: SEARCH.further_starts]:
        gained = max((best.point.chi2 - each.point.chi2 for each in larger), default=0.0)
        rival = SEARCH.crossed_share * enough[0].delta_chi2
        if guess.delta_chi2 < rival <= gained:
            break  # the first does what it promised, and this one promises far less
        larger += _beside(found, best, guess, progress)
    gain = max((each.delta_chi2 for each in larger), default=best.delta_chi2) - best.delta_chi2
    if gain < needed and (leaves_much(found, best) or far_from_prior(best)):
        larger += _beside_as_given(found, best, guesses, progress)
    return best_first(larger)


def _beside(found: SearchResult, best: Trial, guess: Guess, progress: Progress) -> list[Trial]:
    """One more effect beside some, all refitted; empty where that cannot be simulated."""
    effects = (*best.effects, guess.effect)
    progress(" and ".join(effects).replace("_", " "))
    point = started_at_guess(best.point, guess)
    if point is None:
        return []
    point = fitted(with_correction_at_size(fitted(point, 4), guess.effect), 4, restarts=1)
    return [priced(found.baseline, Trial(effects, point, 0.0), found.variance_factor)]


def _beside_as_given(
    found: SearchResult, best: Trial, guesses: Sequence[Guess], progress: Progress
) -> list[Trial]:
    """Further effects beside the best ones in the machine as given.

    Those whose signatures depend on size where much is left; else those whose work the machine does
    although that is improbable of it.
    """
    start = started_as_given(found.nominal, best.point, best.effects)
    if start is None:
        return []
    if leaves_much(found, best):
        fits = global_fits(start, best.point, [each.effect for each in guesses], progress)
    else:
        names = [each.effect for each in guesses if absorbed_by_baseline(best.point, each)]
        some = names[: SEARCH.likely_effects]
        fits = fits_from_nominal(start, best.point, some, progress, best.point.chi2)
    larger = [Trial((*best.effects, name), point, 0.0) for name, point in fits.items()]
    return [priced(found.baseline, each, found.variance_factor) for each in larger]


def _others(found: SearchResult, best: Trial) -> list[Guess]:
    """Guesses for all other effects, less the price of their parameters."""
    point, away = best.point, (*best.effects, *GENERIC)
    names = [name for name in point.space.effects if name not in away]
    price = SEARCH.parameter_price * found.variance_factor
    sizes = SEARCH.sizes_beside if leaves_much(found, best) else SMALL
    every = screened_widely(point, names, sizes, SMALL)
    less = [
        replace(each, delta_chi2=each.delta_chi2 - price * (len(each.places) - 1)) for each in every
    ]
    return sorted(less, key=lambda each: -each.delta_chi2)
