"""Whether what a model leaves hangs together, which noise does not.

Summed over all bins a small effect drowns in noise. What is missing changes slowly, though, and
shows in some channel of some run: so the slowest components of what is left there are compared
with the quick ones, which only noise has, and weighed against chance (F test, Bonferroni over all
that is looked at).

A fit also takes most of what is slow: little of a thing that is missing may be left, and still be
more than a machine whose own values are free leaves of noise. That is asked of the refitted base
(score test, Rao 1948): its slow components in one channel are let free, all else following as if it
had no bounds, and what they would take of the misfit is weighed as chi-squared.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hannes.identification.diagnosis.gauss_newton import LIGHT
from hannes.identification.diagnosis.linearisation import Point

SLOWEST = (8, 24)  # components (discrete cosines) of a channel that are summed; the rest is quick
CHANCE = 0.01  # that nothing is missing, below which something is


@dataclass(frozen=True)
class Slow:
    """What is left of a channel in one run and hangs together.

    where: channel and run, in words; excess: squared standard deviations beyond what noise leaves,
    of `hangs_together` in all channels where that is unlikely, of `stands_out` in this one; chance:
    that noise alone leaves so much anywhere
    """

    where: str
    excess: float
    chance: float


def hangs_together(point: Point) -> Slow | None:
    """The least likely of all that is left; None where chance explains it."""
    squares = [(name, each) for name, each in _squares(point) if each.size > 2 * SLOWEST[-1]]
    if not squares:
        return None
    usual = float(np.median([np.mean(each[SLOWEST[-1] :]) for _, each in squares]))
    found = [_least(name, each, usual) for name, each in squares]
    excess = sum(each.excess for each in found if each.chance < CHANCE)
    least = min(found, key=lambda each: each.chance)
    chance = min(1.0, least.chance * len(found) * len(SLOWEST))
    return replace(least, excess=excess, chance=chance) if chance < CHANCE else None


def stands_out(point: Point) -> Slow | None:
    """The least likely of what a refitted base leaves in one channel of one run; None for chance.

    The noise is as it was told, or as the quick components of most channels have it, if that is
    more: of what acts in a moment quick components have their part too. Where only a few repeats
    tell of the noise, that is not known well enough, and nothing is said.
    """
    if not point.ground.told:
        return None
    squares = [each for _, each in _squares(point) if each.size > 2 * SLOWEST[-1]]
    if not squares:
        return None
    level = max(1.0, float(np.median([np.mean(each[SLOWEST[-1] :]) for each in squares])))
    found = list(_freed(point, level))
    least = min(found, key=lambda each: (each.chance, -each.excess))  # chance may underflow to 0
    chance = min(1.0, least.chance * len(found))
    return replace(least, chance=chance) if chance < CHANCE else None


def _freed(point: Point, level: float) -> Iterator[Slow]:
    """What free slow components of each channel take of the misfit beyond their number."""
    from scipy.fft import idct
    from scipy.stats import chi2

    inverse = np.linalg.inv(point.curvature + LIGHT * np.eye(point.active.size))
    miss = point.miss - point.pull @ inverse @ point.columns
    for place, name, bins in _channels(point):
        if bins <= 2 * SLOWEST[-1]:
            continue
        waves = idct(np.eye(bins), norm="ortho", axis=1)
        for count in SLOWEST:
            left, moved = waves[:count] @ miss[place], point.columns[:, place] @ waves[:count].T
            spread = np.eye(count) - moved.T @ inverse @ moved
            taken = float(left @ np.linalg.solve(spread + LIGHT * np.eye(count), left))
            yield Slow(name, taken - count * level, float(chi2.sf(taken / level, count)))


def _least(name: str, squares: np.ndarray, usual: float) -> Slow:
    """What is less likely of the sums of the slowest components of a channel."""
    from scipy.stats import f

    level, found = max(float(np.mean(squares[SLOWEST[-1] :])), usual), []
    for count in SLOWEST:
        ratio = float(np.mean(squares[:count])) / level
        chance = float(f.sf(ratio, count, squares.size - SLOWEST[-1]))
        found.append(Slow(name, (ratio - 1.0) * count * level, chance))
    return min(found, key=lambda each: each.chance)


def _squares(point: Point) -> list[tuple[str, np.ndarray]]:
    """Channel and run, and squared components of what is left there, slowest first."""
    from scipy.fft import dct

    return [
        (name, dct(point.miss[place], norm="ortho") ** 2) for place, name, _ in _channels(point)
    ]


def _channels(point: Point) -> Iterator[tuple[slice, str, int]]:
    """Where each channel of each group lies, in words too, and its bins."""
    start = 0
    for group in point.ground.model.groups:
        for name in group.names:
            where = f"the {name} of runs like {group.entries[0].name}"
            yield slice(start, start + group.bins), where, group.bins
            start += group.bins
