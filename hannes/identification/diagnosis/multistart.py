"""Fits with one more effect, each from several starting points."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.score_test import Guess, amplitude_names
from hannes.identification.diagnosis.tuning import FIT, NOISE, SEARCH

Progress = Callable[[str], None]
Start = tuple[Linearisation, Guess]
Fits = dict[str, Linearisation]


def predicted_at(baseline: Linearisation, starts: Sequence[Start]) -> dict[str, float]:
    """Effect -> reduction that its guess at the baseline predicts.

    A guess at the machine as given also predicts what the baseline fit has achieved already.
    """
    return {guess.effect: guess.delta_chi2 for at, guess in starts if at is baseline}


def refined(
    nominal: Linearisation,
    baseline: Linearisation,
    fits: Fits,
    predicted: Mapping[str, float],
    progress: Progress,
) -> Fits:
    """The fits, the best few refined with new derivatives, of those below the baseline.

    predicted: effect -> reduction;  one that ends above the baseline failed: the baseline is that
    effect at off
    """
    best, needed = dict(fits), SEARCH.name_limit
    reductions = {
        name: max(baseline.chi2 - point.chi2, predicted.get(name, 0.0))
        for name, point in best.items()
    }
    enough = SEARCH.final_share * max([needed, *reductions.values()])
    most = no_rival(baseline, min((each.chi2 for each in best.values()), default=np.inf))
    below = np.inf
    for name in sorted(reductions, key=lambda each: -reductions[each])[: SEARCH.final_fits]:
        if reductions[name] > enough and best[name].chi2 < most:
            progress(f"{name.replace('_', ' ')}, once more")
            promised = predicted.get(name, 0.0)
            best[name] = _from_both(best[name], baseline, nominal, promised, below)
            below = min(below, _as_a_rival(baseline, best[name]))
    left = min((each.chi2 for each in best.values()), default=np.inf)
    if left < SEARCH.lost_baseline * baseline.residual.size:  # beyond, other missing effects decide
        best = _crossed(best, baseline, needed, progress)
    return {name: point for name, point in best.items() if point.chi2 < baseline.chi2}


def far_above(baseline: Linearisation, left: float) -> float:
    """Chi-squared far above what another effect promises to leave, were that little or much."""
    return SEARCH.far_above * max(left, SEARCH.lost_baseline * baseline.residual.size)


def no_rival(baseline: Linearisation, left: float) -> float:
    """Chi-squared from which on a fit is no rival of one that leaves `left`.

    Far above that; beside one that leaves noise alone, a rival leaves hardly more.
    """
    bins = baseline.residual.size
    if left < bins:
        return SEARCH.lost_baseline * bins
    return far_above(baseline, left)


def _as_a_rival(baseline: Linearisation, leader: Linearisation) -> float:
    """Chi-squared from which on a fit is surely no equal of this one: it need not converge."""
    scale, prices = max(1.0, leader.chi2 / baseline.residual.size), SEARCH.parameter_price
    prices += SEARCH.fault_price  # that the leader may have to pay and a rival not
    delta_chi2 = baseline.chi2 - leader.chi2
    return leader.chi2 + max(scale * (SEARCH.rival + prices), SEARCH.rival_share * delta_chi2)


def first_fits(
    baseline: Linearisation, starts: Sequence[Start], known: Fits, progress: Progress
) -> Fits:
    """Best fit with each effect from every start, derivatives updated on the way, or elsewhere.

    known: fits from elsewhere
    A guess that promises far less than what another effect has reached by then is no rival of it,
    nor is one that leaves far more than the best guess there.
    """
    best: Fits = {}
    promises: dict[int, float] = {}
    for start, guess in starts:
        left = start.chi2 - guess.delta_chi2
        promises[id(start)] = min(left, promises.get(id(start), np.inf))
    most = {key: far_above(baseline, left) for key, left in promises.items()}
    for start, guess in starts:
        found = {**known, **best}
        leader = min(found, key=lambda name: found[name].chi2, default=guess.effect)
        least = found[leader].chi2 if leader in found else np.inf
        share = SEARCH.hopeless if start is baseline else SEARCH.hopeless_as_given
        promised, left = guess.delta_chi2, start.chi2 - guess.delta_chi2
        hopeless = promised < share * (start.chi2 - least) or left > most[id(start)]
        if guess.effect != leader and hopeless:
            continue
        progress(guess.effect.replace("_", " "))
        point = started_at_guess(start, guess)
        if point is None:
            continue
        point = with_correction_at_size(fitted(point, 5), guess.effect)
        if guess.effect not in best or point.chi2 < best[guess.effect].chi2:
            best[guess.effect] = point
    return better(best, known)


def better(fits: Fits, others: Fits) -> Fits:
    """Of each effect's fits the one with the smaller chi-squared."""
    every = [*fits.items(), *others.items()]
    return dict(sorted(every, key=lambda each: -each[1].chi2))


def _from_both(
    point: Linearisation,
    baseline: Linearisation,
    nominal: Linearisation,
    predicted: float,
    below: float,
) -> Linearisation:
    """A converged fit with an effect; from the nominal machine too, where it may be local.

    The baseline is biased to hide an effect, and with contacts a fit from there may stay biased.
    That is suspected where it reduces less than `predicted`, or where the last rounds reduced much;
    not where that is slight, for so is the bias, nor where the fit leaves about noise of a misfit.
    below: chi-squared that it must come near; else it is given up
    """
    found = settled(point, negligible(baseline.chi2 - point.chi2), below)
    delta_chi2 = baseline.chi2 - found.chi2
    far = point.chi2 - found.chi2 > max(SEARCH.far_reduction, SEARCH.far_share * delta_chi2)
    slight, bins = max(delta_chi2, predicted) < SEARCH.slight, point.residual.size
    explains = delta_chi2 > bins and found.chi2 < SEARCH.biased_baseline * bins
    near = not far and delta_chi2 > SEARCH.kept_guess * predicted
    if slight or explains or near:
        return found
    places = np.setdiff1d(point.active, baseline.active)
    there = started_at(with_noise(nominal, point.noise), places, found.x[places])
    below = min(below, found.chi2)
    other = found if there is None else settled(there, negligible(delta_chi2), below)
    return min(found, other, key=lambda each: each.chi2)


def _crossed(best: Fits, baseline: Linearisation, needed: float, progress: Progress) -> Fits:
    """The same fits, with close rivals refitted from the machine of the best effect too.

    With contacts, fits that took other ways may differ by more than their effects do. A rival that
    becomes the best one lends its machine in turn, once.
    """
    best, leaders = dict(best), list[str]()
    while best and len(leaders) < 2:
        leader = min(best, key=lambda name: best[name].chi2)
        if leader in leaders:
            break
        leaders.append(leader)
        delta_chi2 = baseline.chi2 - best[leader].chi2
        for name, point in best.items():
            if name != leader and baseline.chi2 - point.chi2 > SEARCH.crossed_share * max(
                delta_chi2, needed
            ):
                progress(f"{name.replace('_', ' ')}, from there")
                best[name] = _from_machine(best[leader], point, baseline, delta_chi2)
    return best


def _from_machine(
    other: Linearisation, point: Linearisation, baseline: Linearisation, delta_chi2: float
) -> Linearisation:
    """A fit from another one's machine with its own effect; the better of both.

    One that is no rival of the other after some steps is not followed.
    """
    x = point.x.copy()
    x[baseline.active] = other.x[baseline.active]
    there = point.moved(x, np.setdiff1d(point.active, baseline.active))
    there = there and fitted(there, FIT.steps_per_round)
    if there is None or there.chi2 > no_rival(baseline, other.chi2):
        return point
    below = min(point.chi2, _as_a_rival(baseline, other))
    found = settled(there, negligible(delta_chi2), below)
    return min(point, found, key=lambda each: each.chi2)


def fit_beside(
    baseline: Linearisation, guess: Guess, best: Linearisation | None
) -> Linearisation | None:
    """The best fit of a guess, from the baseline or another fit's machine; None if no better."""
    start = started_at_guess(baseline, guess)
    if start is None:
        return None
    point = fitted(start, 5)
    point = settled(point, negligible(baseline.chi2 - point.chi2))
    if best is not None:
        point = _from_machine(best, point, baseline, baseline.chi2 - best.chi2)
    return point if point.chi2 < baseline.chi2 else None


def with_correction_at_size(point: Linearisation, name: str) -> Linearisation:
    """Refitted with the sampled-controller correction at the size that was found."""
    model, places = point.model, point.space.of(name)
    if not model.in_loop(name) or np.abs(point.x[places]).max() <= NOISE.correction_sizes[0]:
        return point
    noise = replace(point.noise, model=model.with_sampling_correction(point.x, [name]))
    there = replace(point, noise=noise).moved(point.x, places)
    return point if there is None else fitted(there, 5)


def started_at_guess(start: Linearisation, guess: Guess) -> Linearisation | None:
    """The start with an effect at the best share of its guess; None where that fails."""
    space, rows = start.space, np.repeat(start.x[np.newaxis], len(SEARCH.guess_shares), axis=0)
    rows[:, guess.places] = guess.x
    amplitudes = [space.place(name) for name in amplitude_names(space.effects[guess.effect])]
    rows[:, amplitudes] *= np.array(SEARCH.guess_shares)[:, np.newaxis]
    active = np.union1d(start.active, guess.places)
    best = rows[np.argmin(start.with_active(active).chi2_at(rows))]
    return started_at(start, guess.places, best[guess.places])


def without(point: Linearisation, effects: Sequence[str]) -> np.ndarray:
    """Points without these effects, with none, half and all of their work taken over linearly.

    Shape (3, size), within bounds.
    """
    space, rows = point.space, np.repeat(point.x[np.newaxis], len(SEARCH.takeover_shares), axis=0)
    rows[:, space.of(*effects)] = 0.0
    names = [name for each in effects for name in amplitude_names(space.effects[each])]
    acting = np.isin(point.active, [space.place(name) for name in names])
    kept = ~np.isin(point.active, space.of(*effects))
    work = point.x[point.active[acting]] @ point.jacobian[acting]
    gradient = point.jacobian[kept] @ work + point.gradient[kept]
    step = np.linalg.solve(point.hessian[np.ix_(kept, kept)], gradient)
    rows[:, point.active[kept]] += np.outer(SEARCH.takeover_shares, step)
    return np.clip(rows, space.low, space.high)


def faded(point: Linearisation, name: str) -> Linearisation | None:
    """The fit with an effect removed gradually, all else following; None where that fails.

    Removed at once it would leave its local minimum: with contacts there are many.
    """
    space = point.space
    places = space.of(name)
    there = point.with_active(np.setdiff1d(point.active, places))
    further = there.active[there.active >= space.uncertain.size]
    for share in SEARCH.fading_shares:
        x = there.x.copy()
        x[places] = share * point.x[places]
        moved = there.moved(x, further)
        if moved is None:
            return None
        there = fitted(moved, 4)
    return there


def started_at(
    start: Linearisation, places: np.ndarray, values: np.ndarray
) -> Linearisation | None:
    """The start with an effect's parameters active and at these values of x."""
    x = start.x.copy()
    x[places] = values
    return start.with_active(np.union1d(start.active, places)).moved(x, np.sort(places))


def started_as_given(
    nominal: Linearisation, point: Linearisation, effects: Sequence[str]
) -> Linearisation | None:
    """The machine as given with effects at the sizes that a fit has, in the noise of that fit."""
    own = point.space.of(*effects)
    return started_at(with_noise(nominal, point.noise), own, point.x[own])


def negligible(delta_chi2: float) -> float:
    """Reduction below which a round is the last, where the whole reduction is this large."""
    return max(FIT.settled, SEARCH.last_round_share * delta_chi2)
