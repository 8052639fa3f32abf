"""Searches for a second effect beside the best one, and for what is left after it."""

from collections.abc import Sequence
from dataclasses import replace

from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.global_starts import global_fits
from hannes.identification.diagnosis.like_faults import varied
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import (
    Progress,
    faded,
    started_at,
    started_at_guess,
    with_correction_at_size,
)
from hannes.identification.diagnosis.score_test import Guess, screened
from hannes.identification.diagnosis.trials import (
    SearchResult,
    Trial,
    best_first,
    converged,
    near,
    priced,
    with_confusable,
)
from hannes.identification.diagnosis.tuning import SEARCH


def with_second_effect(found: SearchResult, progress: Progress) -> SearchResult:
    """Look for a second effect, and for what is left after it."""
    best = found.trials[0]
    needed = max(SEARCH.name_limit, SEARCH.second_share * best.delta_chi2)
    progress("what is left")
    guesses = _others(best.point, best.effects, found.variance_factor)
    enough = [each for each in guesses if each.delta_chi2 >= needed * found.variance_factor]
    starts = [(best, guess) for guess in varied(best.point.space.effects, enough)[:2]]
    pairs = best_first(
        _paired(found, starts, progress) + _paired_globally(found, guesses, progress)
    )
    if not pairs or pairs[0].delta_chi2 - best.delta_chi2 < needed:
        return replace(found, remaining=_refuted(best, guesses, pairs, found.variance_factor))
    for kept in reversed(pairs[0].effects):
        alone = _alone(found, pairs[0], kept, progress)
        if alone is not None and pairs[0].delta_chi2 - alone.delta_chi2 < needed:
            others = [each for each in found.trials if each.effects != alone.effects]
            return with_second_effect(replace(found, trials=[alone, *others]), progress)
    second = next(each for each in guesses if each.effect == pairs[0].effects[-1])
    rivals = [each for each in near(best, found.trials) if second.effect not in each.effects]
    pairs = best_first(pairs + _paired(found, [(each, second) for each in rivals[:2]], progress))
    pairs[0] = converged(found.baseline, pairs[0], found.variance_factor)
    progress("what is left after both")
    after = _others(pairs[0].point, pairs[0].effects, found.variance_factor)
    remaining = after[0] if after else None
    return replace(found, pair=pairs[0], other_pairs=tuple(pairs[1:]), remaining=remaining)


def _refuted(
    best: Trial, guesses: list[Guess], pairs: list[Trial], variance_factor: float
) -> Guess | None:
    """The best of what is left after the best effect: refits where there are any, else guesses.

    pairs: best first
    """
    reductions = {
        each.effects[-1]: (each.delta_chi2 - best.delta_chi2) * variance_factor
        for each in reversed(pairs)
    }
    remaining = [
        replace(g, delta_chi2=reductions[g.effect], refitted=True) if g.effect in reductions else g
        for g in guesses
    ]
    return max(remaining, key=lambda each: each.delta_chi2, default=None)


def _paired(
    found: SearchResult, starts: Sequence[tuple[Trial, Guess]], progress: Progress
) -> list[Trial]:
    """A second effect beside one, both refitted, from each start."""
    pairs = []
    for one, guess in starts:
        progress(f"{one.effects[0]} and {guess.effect}".replace("_", " "))
        point = started_at_guess(one.point, guess)
        if point is not None:
            point = fitted(with_correction_at_size(fitted(point, 4), guess.effect), 4, restarts=1)
            pair = Trial((*one.effects, guess.effect), point, 0.0)
            pairs.append(priced(found.baseline, pair, found.variance_factor))
    return pairs


def _paired_globally(
    found: SearchResult, guesses: Sequence[Guess], progress: Progress
) -> list[Trial]:
    """Second effects whose signatures depend on size, beside the best one."""
    best = found.trials[0]
    own = best.point.space.of(*best.effects)
    start = started_at(with_noise(found.nominal, best.point.noise), own, best.point.x[own])
    if start is None:
        return []
    fits = global_fits(start, best.point, [each.effect for each in guesses], progress)
    pairs = [Trial((*best.effects, name), point, 0.0) for name, point in fits.items()]
    return [priced(found.baseline, pair, found.variance_factor) for pair in pairs]


def _alone(found: SearchResult, pair: Trial, kept: str, progress: Progress) -> Trial | None:
    """One effect of a pair alone: the other may only have led there, or have kept it small.

    Refitted while the other is removed gradually, and from the nominal machine at the size that it
    has in the pair: the nominal machine is not biased by the other.
    """
    (other,) = (name for name in pair.effects if name != kept)
    progress(f"{kept} without {other}".replace("_", " "))
    own = pair.point.space.of(kept)
    nominal = with_noise(found.nominal, pair.point.noise)
    again = started_at(nominal, own, pair.point.x[own])
    starts = (faded(pair.point, other), again and fitted(again, 4))
    trials = [Trial((kept,), start, 0.0) for start in starts if start is not None]
    whole = best_first([converged(found.baseline, each, found.variance_factor) for each in trials])
    return with_confusable(found.baseline, found.guesses, whole[:1])[0] if whole else None


def _others(point: Linearisation, present: tuple[str, ...], variance_factor: float) -> list[Guess]:
    """Guesses for all other effects, less the price of their parameters."""
    away = (*present, *GENERIC)
    names = [name for name in point.space.effects if name not in away]
    price = SEARCH.parameter_price * variance_factor
    found = [
        replace(g, delta_chi2=g.delta_chi2 - price * (len(g.places) - 1))
        for g in screened(point, names)
    ]
    return sorted(found, key=lambda each: -each.delta_chi2)
