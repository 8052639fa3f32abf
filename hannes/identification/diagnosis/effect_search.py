"""Searches for what is missing: baseline, shortlist of single effects, then a second effect."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.effect import Effect
from hannes.identification.diagnosis.baseline import based
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.generic_disturbances import GENERIC_NAMES as GENERIC
from hannes.identification.diagnosis.global_starts import (
    absorbed_by_baseline,
    deepest_minimum,
    fits_from_nominal,
    global_fits,
)
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import (
    Fits,
    Progress,
    faded,
    fit_beside,
    little,
    refitted,
    started_at,
    started_at_guess,
    with_correction_at_size,
    without,
)
from hannes.identification.diagnosis.noise_scale import chi2_reduction, estimated_variance_factor
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.score_test import Guess, cosine_similarity, screened
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class Trial:
    """Effects refitted together.

    delta_chi2: chi-squared of the baseline less the trial's, less the price of its parameters
    confusable: effects whose signatures these recordings hardly separate from the first one's
    """

    effects: tuple[str, ...]
    point: Linearisation = field(repr=False)
    delta_chi2: float
    confusable: tuple[str, ...] = ()


@dataclass(frozen=True)
class SearchResult:
    """Everything that a search found.

    nominal, baseline: the machine as given and refitted;  trials: single effects, best first
    guesses: of the whole catalogue, linear, at the baseline
    pair: two effects, where one is not enough;  other_pairs: refitted beside it
    remaining: the best guess for what is left after the last of them
    variance_factor: variance of the noise over the assumed one, by which chi-squared is divided
    generic: the best generic disturbance, where a guess makes one worth fitting
    """

    nominal: Linearisation
    baseline: Linearisation
    guesses: list[Guess]
    trials: list[Trial]
    pair: Trial | None
    remaining: Guess | None
    variance_factor: float
    other_pairs: tuple[Trial, ...] = ()
    generic: Trial | None = None

    @property
    def bins(self) -> int:
        """How many values are compared."""
        return self.baseline.residual.size


def search_effects(
    plant: Plant,
    entries: Sequence[Entry],
    effects: Sequence[Effect],
    settings: Settings,
    seed: int,
    progress: Progress = lambda text: None,
) -> SearchResult:
    """Search for what is missing; ComputationFailed where the baseline cannot be simulated."""
    groups = grouped(plant, entries)
    nominal, baseline = based(plant, groups, settings, effects, seed, progress)
    names = [each.name for each in effects if each.name not in GENERIC]
    known = global_fits(nominal, baseline, names, progress)
    found = _searched(nominal, baseline, known, progress)
    while (leader := _leading(found)) and (
        better := _back(found.baseline, leader, found.variance_factor, progress)
    ):
        if (
            found.baseline.chi2 - better.chi2
            < SEARCH.second_share * leader.delta_chi2 * found.variance_factor
        ):
            found = _rebased(found, better)
            break
        found = _searched(nominal, better, known, progress)
    return _second(found, progress) if _enough(found) else found


def _enough(found: SearchResult) -> bool:
    """Whether the best effect reduces chi-squared enough for a name."""
    return bool(found.trials) and found.trials[0].delta_chi2 > SEARCH.name_limit


def _leading(found: SearchResult) -> Trial | None:
    """The trial that improved the fit most: one that may be named, else any."""
    every = [*found.trials[:1], *([found.generic] if found.generic else [])]
    named = found.trials[:1] if _enough(found) else every
    best = max(named, key=lambda each: each.delta_chi2, default=None)
    return best if best is not None and best.delta_chi2 > SEARCH.faint else None


def _searched(
    nominal: Linearisation, baseline: Linearisation, known: Fits, progress: Progress
) -> SearchResult:
    """Single effects beside a baseline: screened, the best refitted; known: global fits."""
    progress("a look at every effect")
    every = screened(baseline, list(baseline.space.effects))
    guesses = [each for each in every if each.effect not in GENERIC]
    names = [each.effect for each in guesses]
    likely = [guess for guess in guesses[: SEARCH.shortlist] if guess.delta_chi2 > SEARCH.faint]
    absorbed = [
        g.effect for g in likely if g.effect not in known and absorbed_by_baseline(baseline, g)
    ]
    known = {**known, **fits_from_nominal(nominal, baseline, absorbed, progress)}
    starts = [(baseline, guess) for guess in likely]
    if baseline.chi2 > SEARCH.biased_baseline * baseline.residual.size:
        large = screened(nominal, names, SEARCH.screening_sizes)[: SEARCH.shortlist]
        starts += [(baseline, guess) for guess in guesses[SEARCH.shortlist : 2 * SEARCH.shortlist]]
        starts += [(nominal, guess) for guess in large]
    fits = _deepened(
        nominal,
        baseline,
        refitted(nominal, baseline, starts, known, SEARCH.name_limit, progress),
        progress,
    )
    variance_factor = estimated_variance_factor(
        baseline, min([baseline.chi2, *(each.chi2 for each in fits.values())])
    )
    trials = [
        priced(baseline, Trial((name,), point, 0.0), variance_factor)
        for name, point in fits.items()
    ]
    trials.sort(key=lambda each: -each.delta_chi2)
    if trials and trials[0].delta_chi2 > SEARCH.name_limit:
        trials[0] = _whole(baseline, trials[0], variance_factor)
    confusable = _with_confusable(baseline, guesses, trials)
    free = [each for each in every if each.effect in GENERIC]
    generic = _generic(baseline, free, trials, variance_factor, progress)
    return SearchResult(
        nominal, baseline, guesses, confusable, None, None, variance_factor, generic=generic
    )


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
    best = trials[0].point if trials and trials[0].delta_chi2 > SEARCH.faint else None
    found = []
    for guess in guesses:
        if guess.delta_chi2 / variance_factor >= SEARCH.faint:
            progress(guess.effect.replace("_", " "))
            point = fit_beside(baseline, guess, best)
            found += (
                [priced(baseline, Trial((guess.effect,), point, 0.0), variance_factor)]
                if point
                else []
            )
    return max(found, key=lambda each: each.delta_chi2, default=None)


def _back(
    baseline: Linearisation, best: Trial, variance_factor: float, progress: Progress
) -> Linearisation | None:
    """The baseline refitted from where the best effect led, without it; None where it is no better.

    With contacts chi-squared has several local minima. An effect may only have led out of one. The
    machine's own parameters take over as much of its work as they can.
    """
    progress("the base from there")
    rows = without(best.point, best.effects)
    point = baseline.moved(rows[np.argmin(baseline.chi2_at(rows))], baseline.active)
    if point is None:
        return None
    point = settled(point, little(baseline.chi2 - best.point.chi2), baseline.chi2)
    better = baseline.chi2 - point.chi2 > SEARCH.other_minimum * variance_factor
    return settled(point) if better else None


def _rebased(found: SearchResult, baseline: Linearisation) -> SearchResult:
    """The same result beside a slightly better baseline: every reduction shrinks by that."""
    lost = (found.baseline.chi2 - baseline.chi2) / found.variance_factor
    trials = [
        replace(each, delta_chi2=each.delta_chi2 - lost)
        for each in found.trials
        if each.point.chi2 < baseline.chi2
    ]
    generic = found.generic and replace(found.generic, delta_chi2=found.generic.delta_chi2 - lost)
    return replace(found, baseline=baseline, trials=trials, generic=generic)


def _deepened(
    nominal: Linearisation, baseline: Linearisation, fits: Fits, progress: Progress
) -> Fits:
    """The fits with the best one refitted around its size, if its signature depends on size."""
    best = min(fits, key=lambda name: fits[name].chi2, default=None)
    if best is None or fits[best].chi2 > baseline.chi2 - SEARCH.name_limit:
        return fits
    progress(f"{best.replace('_', ' ')}, from about there")
    return {**fits, best: deepest_minimum(nominal, fits[best], best)}


def _whole(baseline: Linearisation, trial: Trial, variance_factor: float) -> Trial:
    """The trial with its fit converged: its parameters are reported."""
    return priced(baseline, replace(trial, point=settled(trial.point)), variance_factor)


def priced(baseline: Linearisation, trial: Trial, variance_factor: float) -> Trial:
    """The trial with its reduction of chi-squared, less the price of its parameters."""
    further = trial.point.active.size - baseline.active.size - len(trial.effects)
    price = SEARCH.generic_price if trial.effects[0] in GENERIC else SEARCH.parameter_price
    return replace(
        trial, delta_chi2=chi2_reduction(baseline, trial.point, variance_factor) - price * further
    )


def _second(found: SearchResult, progress: Progress) -> SearchResult:
    """Look for a second effect, and for what is left after it."""
    best = found.trials[0]
    needed = max(SEARCH.name_limit, SEARCH.second_share * best.delta_chi2)
    progress("what is left")
    guesses = _others(best.point, best.effects, found.variance_factor)
    starts = [
        (best, guess) for guess in guesses[:2] if guess.delta_chi2 >= needed * found.variance_factor
    ]
    pairs = _sorted(_paired(found, starts, progress) + _paired_globally(found, guesses, progress))
    if not pairs or pairs[0].delta_chi2 - best.delta_chi2 < needed:
        return replace(found, remaining=_refuted(best, guesses, pairs, found.variance_factor))
    for kept in reversed(pairs[0].effects):
        alone = _alone(found, pairs[0], kept, progress)
        if alone is not None and pairs[0].delta_chi2 - alone.delta_chi2 < needed:
            others = [each for each in found.trials if each.effects != alone.effects]
            return _second(replace(found, trials=[alone, *others]), progress)
    second = next(each for each in guesses if each.effect == pairs[0].effects[-1])
    rivals = [each for each in near(best, found.trials) if second.effect not in each.effects]
    pairs = _sorted(pairs + _paired(found, [(each, second) for each in rivals[:2]], progress))
    pairs[0] = _whole(found.baseline, pairs[0], found.variance_factor)
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
    remaining = [replace(g, delta_chi2=reductions.get(g.effect, g.delta_chi2)) for g in guesses]
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
            point = fitted(with_correction_at_size(fitted(point, 4), guess.effect), 4, anew=1)
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


def _sorted(pairs: Sequence[Trial]) -> list[Trial]:
    return sorted(pairs, key=lambda each: -each.delta_chi2)


def near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """The trials that these recordings do not separate from the best one."""
    within = max(SEARCH.rival, SEARCH.rival_share * best.delta_chi2)
    return [
        t for t in trials if t.effects != best.effects and best.delta_chi2 - t.delta_chi2 < within
    ]


def _alone(found: SearchResult, pair: Trial, kept: str, progress: Progress) -> Trial | None:
    """One effect of a pair alone: the other may only have led there, or have kept it small.

    Refitted while the other is removed gradually, and from the nominal machine at the size that it
    has in the pair: the nominal machine is not biased by the other.
    """
    (other,) = (name for name in pair.effects if name != kept)
    progress(f"{kept} without {other}".replace("_", " "))
    own = pair.point.space.of(kept)
    nominal = with_noise(found.nominal, pair.point.noise)
    anew = started_at(nominal, own, pair.point.x[own])
    starts = (faded(pair.point, other), anew and fitted(anew, 4))
    trials = [Trial((kept,), start, 0.0) for start in starts if start is not None]
    whole = _sorted([_whole(found.baseline, each, found.variance_factor) for each in trials])
    return _with_confusable(found.baseline, found.guesses, whole[:1])[0] if whole else None


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


def _with_confusable(
    baseline: Linearisation, guesses: Sequence[Guess], trials: list[Trial]
) -> list[Trial]:
    columns = {guess.effect: guess.signature for guess in guesses}
    return [
        replace(
            each,
            confusable=tuple(
                name
                for name in columns
                if name != each.effects[0]
                and cosine_similarity(baseline, columns[each.effects[0]], columns[name])
                > SEARCH.confusable_cosine
            ),
        )
        for each in trials
    ]
