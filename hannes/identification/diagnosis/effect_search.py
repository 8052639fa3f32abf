"""From recordings to what is missing: the base refitted, a short list refitted, a second effect."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.effect import Effect
from hannes.identification.diagnosis.baseline import based
from hannes.identification.diagnosis.gauss_newton import fitted, settled
from hannes.identification.diagnosis.generic_disturbances import SPOKEN as NAMELESS
from hannes.identification.diagnosis.global_starts import bent_to, deepest, from_afar, put_in
from hannes.identification.diagnosis.linearisation import Point, grounded
from hannes.identification.diagnosis.multistart import (
    Fits,
    Told,
    beside,
    faded,
    joined,
    little,
    placed,
    refitted,
    ticked,
    without,
)
from hannes.identification.diagnosis.noise_scale import lowered, noise_left
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.score_test import ALL_SIZES, Guess, likeness, screened
from hannes.identification.diagnosis.settings import Settings
from hannes.plants.protocol import Plant

SHORT = 5  # effects of each screening that are refitted
FAINT = 6.0  # a guess that gains less is not refitted
BENT = 1.3  # times the bins: a base that leaves more may hide an effect by bending to it
LIMIT = 12.0  # gain of an effect that is named: more than chance gives any of a catalogue
PRICE = 6.0  # of each parameter of an effect beyond its first: the more it has, the more it fits
CHANCE = 1.5  # the same of an effect without a name: about what chance gives a parameter
RIVAL = 10.0  # a rival within so much of the best gain is not told from it
CLOSE = 0.08  # of the best gain: so near a rival may come by what no model has right
SHARE = 0.04  # of the first effect's gain that a second one needs
HOLLOW = 2.0  # gain by which a base found from elsewhere is another one
ALIKE = 0.95  # cosine of two effects that these recordings hardly tell apart
CLEAN = 1.3  # times the bins: what a whole model leaves at most


@dataclass(frozen=True)
class Trial:
    """Effects refitted together.

    gain: how much of the base's misfit they take away, less the price of their parameters
    alike: effects whose marks these recordings hardly tell from the first one's
    """

    effects: tuple[str, ...]
    point: Point = field(repr=False)
    gain: float
    alike: tuple[str, ...] = ()


@dataclass(frozen=True)
class Found:
    """Everything that came of an investigation.

    given: with everything as given; base: the base refitted; trials: single effects, best first;
    guesses: of the whole catalogue, linear, at the base that was searched from; pair: two effects,
    where one leaves more, and other_pairs that were refitted beside it; rest: the best guess of
    what is left after the last of them
    unit: by how much misfits are divided: the noise is what the best model leaves, within limits
    anything: the best effect without a name refitted, where a guess says that this is worth while
    """

    given: Point
    base: Point
    guesses: list[Guess]
    trials: list[Trial]
    pair: Trial | None
    rest: Guess | None
    unit: float
    other_pairs: tuple[Trial, ...] = ()
    anything: Trial | None = None

    @property
    def bins(self) -> int:
        """How many numbers are compared."""
        return self.base.miss.size


def investigate(
    plant: Plant,
    entries: Sequence[Entry],
    effects: Sequence[Effect],
    settings: Settings,
    seed: int,
    told: Told = lambda text: None,
) -> Found:
    """Search what is missing. Raises ComputationFailed where the base cannot be simulated."""
    groups = grouped(plant, entries)
    given, base = based(plant, groups, settings, effects, seed, told)
    names = [each.name for each in effects if each.name not in NAMELESS]
    known = from_afar(given, base, names, told)
    found = _searched(given, base, known, told)
    while (leader := _leading(found)) and (better := _back(found.base, leader, found.unit, told)):
        if found.base.misfit - better.misfit < SHARE * leader.gain * found.unit:
            found = _rebased(found, better)
            break
        found = _searched(given, better, known, told)
    return _second(found, told) if _enough(found) else found


def _enough(found: Found) -> bool:
    """Tell whether the best effect gains what a name needs."""
    return bool(found.trials) and found.trials[0].gain > LIMIT


def _leading(found: Found) -> Trial | None:
    """What led the fit furthest: an effect that gains what a name needs, else whatever did."""
    every = [*found.trials[:1], *([found.anything] if found.anything else [])]
    named = found.trials[:1] if _enough(found) else every
    best = max(named, key=lambda each: each.gain, default=None)
    return best if best is not None and best.gain > FAINT else None


def _searched(given: Point, base: Point, known: Fits, told: Told) -> Found:
    """Single effects beside a base: screened, the best of them refitted; known: fits from afar."""
    told("a look at every effect")
    every = screened(base, list(base.ground.model.space.effects))
    guesses = [each for each in every if each.effect not in NAMELESS]
    names = [each.effect for each in guesses]
    likely = [guess for guess in guesses[:SHORT] if guess.gain > FAINT]
    bent = [g.effect for g in likely if g.effect not in known and bent_to(base, g)]
    known = {**known, **put_in(given, base, bent, told)}
    starts = [(base, guess) for guess in likely]
    if base.misfit > BENT * base.miss.size:
        large = screened(given, names, ALL_SIZES)[:SHORT]
        starts += [(base, guess) for guess in guesses[SHORT : 2 * SHORT]]
        starts += [(given, guess) for guess in large]
    fits = _deepened(given, base, refitted(given, base, starts, known, LIMIT, told), told)
    unit = noise_left(base, min([base.misfit, *(each.misfit for each in fits.values())]))
    trials = [priced(base, Trial((name,), point, 0.0), unit) for name, point in fits.items()]
    trials.sort(key=lambda each: -each.gain)
    if trials and trials[0].gain > LIMIT:
        trials[0] = _whole(base, trials[0], unit)
    alike = _with_likeness(base, guesses, trials)
    free = [each for each in every if each.effect in NAMELESS]
    anything = _anything(base, free, trials, unit, told)
    return Found(given, base, guesses, alike, None, None, unit, anything=anything)


def _anything(
    base: Point, guesses: Sequence[Guess], trials: Sequence[Trial], unit: float, told: Told
) -> Trial | None:
    """The best effect without a name, each fitted where its guess gains anything: refits gain more.

    From the base, and from the machine of the best effect; never before the others: what it bends
    is not theirs.
    """
    best = trials[0].point if trials and trials[0].gain > FAINT else None
    found = []
    for guess in guesses:
        if guess.gain / unit >= FAINT:
            told(guess.effect.replace("_", " "))
            point = beside(base, guess, best)
            found += [priced(base, Trial((guess.effect,), point, 0.0), unit)] if point else []
    return max(found, key=lambda each: each.gain, default=None)


def _back(base: Point, best: Trial, unit: float, told: Told) -> Point | None:
    """The base refitted from where the best effect led, without it; None where that is no better.

    Where fingers touch the misfit has more than one hollow: an effect may only have led out of one.
    The machine's own values take over from it what they can.
    """
    told("the base from there")
    rows = without(best.point, best.effects)
    point = base.moved(rows[np.argmin(base.misfits(rows))], base.active)
    if point is None:
        return None
    point = settled(point, little(base.misfit - best.point.misfit), base.misfit)
    better = base.misfit - point.misfit > HOLLOW * unit
    return settled(point) if better else None


def _rebased(found: Found, base: Point) -> Found:
    """The same beside a base that is little better: all effects gain less by that."""
    lost = (found.base.misfit - base.misfit) / found.unit
    trials = [
        replace(each, gain=each.gain - lost)
        for each in found.trials
        if each.point.misfit < base.misfit
    ]
    anything = found.anything and replace(found.anything, gain=found.anything.gain - lost)
    return replace(found, base=base, trials=trials, anything=anything)


def _deepened(given: Point, base: Point, fits: Fits, told: Told) -> Fits:
    """The fits with the best one refitted from about where it lies, if its mark turns."""
    best = min(fits, key=lambda name: fits[name].misfit, default=None)
    if best is None or fits[best].misfit > base.misfit - LIMIT:
        return fits
    told(f"{best.replace('_', ' ')}, from about there")
    return {**fits, best: deepest(given, fits[best], best)}


def _whole(base: Point, trial: Trial, unit: float) -> Trial:
    """The trial with its fit gone on to its end: what it tells of parameters is for the user."""
    return priced(base, replace(trial, point=settled(trial.point)), unit)


def priced(base: Point, trial: Trial, unit: float) -> Trial:
    """The trial with its gain: misfit less than the base's, less the price of its parameters."""
    further = trial.point.active.size - base.active.size - len(trial.effects)
    price = CHANCE if trial.effects[0] in NAMELESS else PRICE
    return replace(trial, gain=lowered(base, trial.point, unit) - price * further)


def _second(found: Found, told: Told) -> Found:
    """Look for more than the best effect explains: a second effect, and what is left after it."""
    best = found.trials[0]
    needed = max(LIMIT, SHARE * best.gain)
    told("what is left")
    guesses = _others(best.point, best.effects, found.unit)
    starts = [(best, guess) for guess in guesses[:2] if guess.gain >= needed * found.unit]
    pairs = _sorted(_paired(found, starts, told) + _paired_from_afar(found, guesses, told))
    if not pairs or pairs[0].gain - best.gain < needed:
        return replace(found, rest=_refuted(best, guesses, pairs, found.unit))
    for kept in reversed(pairs[0].effects):
        alone = _alone(found, pairs[0], kept, told)
        if alone is not None and pairs[0].gain - alone.gain < needed:
            others = [each for each in found.trials if each.effects != alone.effects]
            return _second(replace(found, trials=[alone, *others]), told)
    second = next(each for each in guesses if each.effect == pairs[0].effects[-1])
    rivals = [each for each in near(best, found.trials) if second.effect not in each.effects]
    pairs = _sorted(pairs + _paired(found, [(each, second) for each in rivals[:2]], told))
    pairs[0] = _whole(found.base, pairs[0], found.unit)
    told("what is left after both")
    after = _others(pairs[0].point, pairs[0].effects, found.unit)
    rest = after[0] if after else None
    return replace(found, pair=pairs[0], other_pairs=tuple(pairs[1:]), rest=rest)


def _refuted(best: Trial, guesses: list[Guess], pairs: list[Trial], unit: float) -> Guess | None:
    """The best of what is left after the best effect: refits beside it, guesses for all others.

    pairs: best first
    """
    gains = {each.effects[-1]: (each.gain - best.gain) * unit for each in reversed(pairs)}
    rest = [replace(g, gain=gains.get(g.effect, g.gain)) for g in guesses]
    return max(rest, key=lambda each: each.gain, default=None)


def _paired(found: Found, starts: Sequence[tuple[Trial, Guess]], told: Told) -> list[Trial]:
    """A second effect beside one, refitted together, from each start."""
    pairs = []
    for one, guess in starts:
        told(f"{one.effects[0]} and {guess.effect}".replace("_", " "))
        point = joined(one.point, guess)
        if point is not None:
            point = fitted(ticked(fitted(point, 4), guess.effect), 4, anew=1)
            pair = Trial((*one.effects, guess.effect), point, 0.0)
            pairs.append(priced(found.base, pair, found.unit))
    return pairs


def _paired_from_afar(found: Found, guesses: Sequence[Guess], told: Told) -> list[Trial]:
    """Second effects whose marks turn, beside the best one."""
    best = found.trials[0]
    own = best.point.ground.model.space.of(*best.effects)
    start = placed(grounded(found.given, best.point.ground), own, best.point.x[own])
    if start is None:
        return []
    fits = from_afar(start, best.point, [each.effect for each in guesses], told)
    pairs = [Trial((*best.effects, name), point, 0.0) for name, point in fits.items()]
    return [priced(found.base, pair, found.unit) for pair in pairs]


def _sorted(pairs: Sequence[Trial]) -> list[Trial]:
    return sorted(pairs, key=lambda each: -each.gain)


def near(best: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """Of some trials those that these recordings do not tell from the best one."""
    within = max(RIVAL, CLOSE * best.gain)
    return [t for t in trials if t.effects != best.effects and best.gain - t.gain < within]


def _alone(found: Found, pair: Trial, kept: str, told: Told) -> Trial | None:
    """One effect of a pair alone: the other may only have led there, or have kept it small.

    Refitted as the other is let go, and at the size that it has in the pair from the machine as
    given, which has not bent to the other.
    """
    (other,) = (name for name in pair.effects if name != kept)
    told(f"{kept} without {other}".replace("_", " "))
    own = pair.point.ground.model.space.of(kept)
    given = grounded(found.given, pair.point.ground)
    anew = placed(given, own, pair.point.x[own])
    starts = (faded(pair.point, other), anew and fitted(anew, 4))
    trials = [Trial((kept,), start, 0.0) for start in starts if start is not None]
    whole = _sorted([_whole(found.base, each, found.unit) for each in trials])
    return _with_likeness(found.base, found.guesses, whole[:1])[0] if whole else None


def _others(point: Point, present: tuple[str, ...], unit: float) -> list[Guess]:
    """Guesses for all other effects, the price of their parameters off their gain."""
    away = (*present, *NAMELESS)
    names = [name for name in point.ground.model.space.effects if name not in away]
    price = PRICE * unit
    found = [replace(g, gain=g.gain - price * (len(g.places) - 1)) for g in screened(point, names)]
    return sorted(found, key=lambda each: -each.gain)


def _with_likeness(base: Point, guesses: Sequence[Guess], trials: list[Trial]) -> list[Trial]:
    columns = {guess.effect: guess.columns for guess in guesses}
    return [
        replace(
            each,
            alike=tuple(
                name
                for name in columns
                if name != each.effects[0]
                and likeness(base, columns[each.effects[0]], columns[name]) > ALIKE
            ),
        )
        for each in trials
    ]
