"""Whether what a model leaves hangs together, which noise does not.

Summed over all bins a small effect drowns in noise. What is missing changes slowly, though, and
shows in some channel of some run: so the slowest components of what is left there are compared
with the quick ones, which only noise has, and weighed against chance (F test, Bonferroni over all
that is looked at).
"""

from dataclasses import dataclass, replace

import numpy as np

from hannes.diagnosis.point import Point

SLOWEST = (8, 24)  # components (discrete cosines) of a channel that are summed; the rest is quick
CHANCE = 0.01  # that nothing is missing, below which something is


@dataclass(frozen=True)
class Slow:
    """What is left of a channel in one run and hangs together.

    where: channel and run, in words; excess: squared standard deviations beyond what noise leaves,
    in all channels where that is unlikely; chance: that noise alone leaves so much anywhere
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

    start, found = 0, []
    for group in point.ground.model.groups:
        for name in group.names:
            left = point.miss[start : start + group.bins]
            where = f"the {name} of runs like {group.entries[0].name}"
            found.append((where, dct(left, norm="ortho") ** 2))
            start += group.bins
    return found
