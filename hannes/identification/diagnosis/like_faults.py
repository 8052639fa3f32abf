"""The best fault of a part, tried in every other like part: recordings may not separate these."""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.core.effect import Effect
from hannes.identification.diagnosis.gauss_newton import fitted, rounds, settled
from hannes.identification.diagnosis.linearisation import Linearisation, with_noise
from hannes.identification.diagnosis.multistart import Fits, Progress, negligible, started_at
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.part_fault import like_faults


def with_like_faults(
    nominal: Linearisation, baseline: Linearisation, fits: Fits, best: str, progress: Progress
) -> Fits:
    """The fits with that of the best one tried in the other parts, as large as it is in its own.

    One that leaves less takes its place, and those that come near it fast go on. Of these one that
    is still above it starts from the machine as given too: the best one's machine is biased by it.
    """
    others = like_faults(baseline.space.effects, best)
    if not others:
        return fits
    found, first, leader = dict(fits), best, fits[best]
    led = {first: first}  # by whom a fault was led
    for name in others:
        progress(f"{name.replace('_', ' ')}, as {best.replace('_', ' ')}")
        led[name] = best
        points = [transferred(baseline, leader, best, name), found.get(name)]
        there = [each for each in points if each is not None and each.chi2 < baseline.chi2]
        if there:
            found[name] = min(there, key=lambda each: each.chi2)
            best = min(best, name, key=lambda each: found[each].chi2)
            leader = found[best]
    found = _led_again(baseline, found, best, led, progress)
    best = min((name for name in led if name in found), key=lambda name: found[name].chi2)
    for name in (first, *others):
        if name in found and (name != first or best != first):
            found[name] = _caught_up(baseline, found[best], found[name])
            found[name] = _from_as_given(nominal, baseline, found, best, name)
    return found


def _from_as_given(
    nominal: Linearisation,
    baseline: Linearisation,
    fits: Fits,
    best: str,
    name: str,
) -> Linearisation:
    """A rival's fit, or one from the machine as given where that leaves less.

    As large as it is in its fit, and as the best one is: contacts make local minima between.
    """
    leader, point = fits[best], fits[name]
    if not SEARCH.rival < point.chi2 - leader.chi2 < SEARCH.rounds_behind * SEARCH.rival:
        return point
    own, given = point.space.of(name), with_noise(nominal, point.noise)
    sizes = point.x[own], leader.x[leader.space.of(best)]
    starts = [started_at(given, own, size) for size in sizes]
    little = negligible(baseline.chi2 - leader.chi2)
    others = [settled(fitted(each, 4), little, leader.chi2) for each in starts if each is not None]
    return min([point, *others], key=lambda each: each.chi2)


def _led_again(
    baseline: Linearisation, fits: Fits, best: str, led: Mapping[str, str], progress: Progress
) -> Fits:
    """The fits with rivals of the best one started from it, where an earlier one had led them.

    One that was led by a worse fit may have come to rest above its own least.
    """
    found, leader = dict(fits), fits[best]
    least = SEARCH.like_share * (baseline.chi2 - leader.chi2)
    for name, by in led.items():
        if name not in found or best in (name, by) or baseline.chi2 - found[name].chi2 < least:
            continue
        progress(f"{name.replace('_', ' ')}, as {best.replace('_', ' ')}")
        point = transferred(baseline, leader, best, name)
        if point is not None:
            found[name] = min(found[name], point, key=lambda each: each.chi2)
    return found


def _caught_up(
    baseline: Linearisation, leader: Linearisation, point: Linearisation
) -> Linearisation:
    """A rival whose rounds ended early, followed while few more such rounds could reach the best.

    Parts that recordings do not separate end near each other; others stay far above.
    """
    few = SEARCH.rounds_behind * SEARCH.rival
    made, near = rounds(point), max(few, SEARCH.rival_share * (baseline.chi2 - leader.chi2))
    while True:
        above = point.chi2 - leader.chi2
        reach = max(few, SEARCH.rounds_behind * point.last_reduction)
        further = next(made, None) if above < min(near, reach) else None
        if further is None:
            return point
        point = further


def varied(effects: Mapping[str, Effect], guesses: Sequence[Guess]) -> list[Guess]:
    """The guesses, of the same fault of several parts the first alone."""
    found: list[Guess] = []
    for each in guesses:
        if not set(like_faults(effects, each.effect)) & {known.effect for known in found}:
            found.append(each)
    return found


def transferred(
    baseline: Linearisation, leader: Linearisation, best: str, name: str
) -> Linearisation | None:
    """A fit of one fault from the machine and the size of another."""
    space, x = leader.space, leader.x.copy()
    own, other = space.of(name), space.of(best)
    x[own], x[other] = leader.x[other], 0.0
    active = np.union1d(np.setdiff1d(leader.active, other), own)
    start = leader.with_active(active).moved(x, np.sort(own))
    if start is None:
        return None
    return settled(fitted(start, 4), negligible(baseline.chi2 - leader.chi2), leader.chi2)
