"""Fits with one effect more, begun where they may arrive: the best few from several ends."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import SETTLED, fitted, settled
from hannes.identification.diagnosis.linearisation import Point, grounded
from hannes.identification.diagnosis.score_test import Guess, amplitude_names
from hannes.identification.diagnosis.simulator import TICKED

SHARES = (1.0, 0.5, 0.2, 0.05)  # of a guess: a start is at the best, where fingers touch none holds
FINAL = 3  # fits that are had with all slopes anew,
NEAR = 0.5  # where they gain this share of the most, and of what a name needs
HELD = 0.7  # of what its guess promised: a fit that gains less was led astray,
ASTRAY = 10.0  # or one that slopes had anew lower by so much more,
FAR = 0.05  # and by this share of the gain
CROSSED = 0.6  # of the best gain: a rival that gains this is fitted from the best one's machine too
TAKEN = (0.0, 0.5, 1.0)  # of what an effect did: shares that all else takes over where it goes
FADING = (0.75, 0.5, 0.25, 0.0)  # of an effect that is let go, all else fitted after each
LITTLE = 0.005  # of the gain: a round of slopes that lowers the misfit by less is the last

Told = Callable[[str], None]
Start = tuple[Point, Guess]
Fits = dict[str, Point]


def refitted(
    given: Point, base: Point, starts: Sequence[Start], known: Fits, needed: float, told: Told
) -> Fits:
    """Best fit with each effect from every start, below the base; the best few from several ends.

    known: fits from elsewhere; needed: gain that a name needs. What ended above the base did not
    get there: the base is that effect at off.
    """
    best = _better(_started(starts, told), known)
    # A guess at the machine as given promises what refitting the base has brought already.
    hoped = dict.fromkeys(best, 0.0) | {g.effect: g.gain for at, g in starts if at is base}
    gains = {name: max(base.misfit - point.misfit, hoped[name]) for name, point in best.items()}
    enough = NEAR * max([needed, *gains.values()])
    for name in sorted(gains, key=lambda each: -gains[each])[:FINAL]:
        if gains[name] > enough:
            told(f"{name.replace('_', ' ')}, once more")
            best[name] = _from_both(best[name], base, given, hoped[name])
    best = _crossed(best, base, needed, told)
    return {name: point for name, point in best.items() if point.misfit < base.misfit}


def _started(starts: Sequence[Start], told: Told) -> Fits:
    """Best fit with each effect from every start, slopes mended as it goes."""
    best: Fits = {}
    for start, guess in starts:
        told(guess.effect.replace("_", " "))
        point = joined(start, guess)
        if point is None:
            continue
        point = ticked(fitted(point, 5), guess.effect)
        if guess.effect not in best or point.misfit < best[guess.effect].misfit:
            best[guess.effect] = point
    return best


def _better(fits: Fits, others: Fits) -> Fits:
    """Of every effect's fits the one that leaves less."""
    every = [*fits.items(), *others.items()]
    return dict(sorted(every, key=lambda each: -each[1].misfit))


def _from_both(point: Point, base: Point, given: Point, hoped: float) -> Point:
    """A fit with an effect settled; where it was led astray, from the machine as given too.

    The base bends to hide an effect; where fingers touch a fit from there may stay bent. It does
    where it gains less than what was `hoped` for, or where it had far to go.
    """
    found = settled(point, little(base.misfit - point.misfit))
    gain = base.misfit - found.misfit
    far = point.misfit - found.misfit > max(ASTRAY, FAR * gain)
    if not far and gain > HELD * hoped:
        return found
    places = np.setdiff1d(point.active, base.active)
    there = placed(grounded(given, point.ground), places, found.x[places])
    other = found if there is None else settled(there, little(gain), found.misfit)
    return min(found, other, key=lambda each: each.misfit)


def _crossed(best: Fits, base: Point, needed: float, told: Told) -> Fits:
    """The same, rivals that gain nearly as much as the best effect fitted from its machine as well.

    Where fingers touch, fits that went other ways may differ by more than their effects do. A
    rival that is the best one then lends its machine in turn, once.
    """
    best, leaders = dict(best), list[str]()
    while best and len(leaders) < 2:
        leader = min(best, key=lambda name: best[name].misfit)
        if leader in leaders:
            break
        leaders.append(leader)
        gain = base.misfit - best[leader].misfit
        for name, point in best.items():
            if name != leader and base.misfit - point.misfit > CROSSED * max(gain, needed):
                told(f"{name.replace('_', ' ')}, from there")
                best[name] = _from_machine(best[leader], point, base, gain)
    return best


def _from_machine(other: Point, point: Point, base: Point, gain: float) -> Point:
    """A fit begun anew at another one's machine, its own effect kept; the better of both."""
    x = point.x.copy()
    x[base.active] = other.x[base.active]
    there = point.moved(x, np.setdiff1d(point.active, base.active))
    if there is None:
        return point
    found = settled(there, little(gain), point.misfit)
    return min(point, found, key=lambda each: each.misfit)


def beside(base: Point, guess: Guess, best: Point | None) -> Point | None:
    """The best fit of a guess from the base, and from another fit's machine; None below neither."""
    start = joined(base, guess)
    if start is None:
        return None
    point = fitted(start, 5)
    point = settled(point, little(base.misfit - point.misfit))
    if best is not None:
        point = _from_machine(best, point, base, base.misfit - best.misfit)
    return point if point.misfit < base.misfit else None


def ticked(point: Point, name: str) -> Point:
    """Refitted with firmware's ticks as they are at the size at which an effect was found."""
    model, places = point.ground.model, point.ground.model.space.of(name)
    if not model.in_loop(name) or np.abs(point.x[places]).max() <= TICKED[0]:
        return point
    ground = replace(point.ground, model=model.ticking(point.x, [name]))
    there = replace(point, ground=ground).moved(point.x, places)
    return point if there is None else fitted(there, 5)


def joined(start: Point, guess: Guess) -> Point | None:
    """The start with an effect at the best share of its guess; None where that breaks down."""
    space, rows = start.ground.model.space, np.repeat(start.x[np.newaxis], len(SHARES), axis=0)
    rows[:, guess.places] = guess.x
    amplitudes = [space.place(name) for name in amplitude_names(space.effects[guess.effect])]
    rows[:, amplitudes] *= np.array(SHARES)[:, np.newaxis]
    active = np.union1d(start.active, guess.places)
    best = rows[np.argmin(start.with_active(active).misfits(rows))]
    return placed(start, guess.places, best[guess.places])


def without(point: Point, effects: Sequence[str]) -> np.ndarray:
    """Places without these effects: as it is else, and where all else takes their work over.

    That by a linear guess, whole and by half; shape (3, size), within bounds.
    """
    space, rows = point.ground.model.space, np.repeat(point.x[np.newaxis], len(TAKEN), axis=0)
    rows[:, space.of(*effects)] = 0.0
    names = [name for each in effects for name in amplitude_names(space.effects[each])]
    acting = np.isin(point.active, [space.place(name) for name in names])
    kept = ~np.isin(point.active, space.of(*effects))
    work = point.x[point.active[acting]] @ point.columns[acting]
    pull = point.columns[kept] @ work + point.pull[kept]
    step = np.linalg.solve(point.curvature[np.ix_(kept, kept)], pull)
    rows[:, point.active[kept]] += np.outer(TAKEN, step)
    return np.clip(rows, space.low, space.high)


def faded(point: Point, name: str) -> Point | None:
    """The fit with an effect let go little by little, all else following; None where it breaks.

    Taken away at once it would leave the hollow that it led to: where fingers touch others are
    all about.
    """
    space = point.ground.model.space
    places = space.of(name)
    there = point.with_active(np.setdiff1d(point.active, places))
    further = there.active[there.active >= space.uncertain.size]
    for share in FADING:
        x = there.x.copy()
        x[places] = share * point.x[places]
        moved = there.moved(x, further)
        if moved is None:
            return None
        there = fitted(moved, 4)
    return there


def placed(start: Point, places: np.ndarray, values: np.ndarray) -> Point | None:
    """The start with an effect's directions active and at these values of x."""
    x = start.x.copy()
    x[places] = values
    return start.with_active(np.union1d(start.active, places)).moved(x, np.sort(places))


def little(gain: float) -> float:
    """What a round may gain and be the last, where so much is gained in all."""
    return max(SETTLED, LITTLE * gain)
