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

    where: channel and run, in words; excess: squared standard deviations beyond what noise leaves;
    chance: that noise alone leaves so much anywhere
    """

    where: str
    excess: float
    chance: float


def hangs_together(point: Point) -> Slow | None:
    """The least likely of all that is left; None where chance explains it."""
    from scipy.stats import f

    squares = {name: each for name, each in _squares(point).items() if each.size > 2 * SLOWEST[-1]}
    if not squares:
        return None
    quick = {name: float(np.mean(each[SLOWEST[-1] :])) for name, each in squares.items()}
    usual, found = float(np.median(list(quick.values()))), []
    for name, each in squares.items():
        level = max(quick[name], usual)
        for count in SLOWEST:
            ratio = float(np.mean(each[:count])) / level
            chance = float(f.sf(ratio, count, each.size - SLOWEST[-1]))
            found.append(Slow(name, (ratio - 1.0) * count * level, chance))
    least = min(found, key=lambda each: each.chance)
    least = replace(least, chance=min(1.0, least.chance * len(found)))
    return least if least.chance < CHANCE else None


def _squares(point: Point) -> dict[str, np.ndarray]:
    """Channel and run -> squared components of what is left there, slowest first."""
    from scipy.fft import dct

    start, found = 0, {}
    for group in point.ground.model.groups:
        for name in group.names:
            left = point.miss[start : start + group.bins]
            found[f"the {name} of {group.entries[0].name}"] = dct(left, norm="ortho") ** 2
            start += group.bins
    return found
