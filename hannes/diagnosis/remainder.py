"""Whether what a model leaves hangs together, which noise does not.

Summed over all bins a small effect drowns in noise. What is missing changes slowly, though, and
shows in some channel of some run: so the slowest components of what is left there are weighed by
themselves, against chance alone (Bonferroni over all that is looked at).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hannes.diagnosis.point import Point

SLOWEST = (8, 24)  # components (discrete cosines) of a channel that are summed
CHANCE = 0.05  # that nothing is missing, below which something is


@dataclass(frozen=True)
class Slow:
    """What is left of a channel in one run and hangs together.

    where: channel and run, in words; excess: squared standard deviations beyond what is expected;
    chance: that noise alone leaves so much anywhere
    """

    where: str
    excess: float
    chance: float


def hangs_together(point: Point) -> Slow | None:
    """The least likely of all that is left; None where chance explains it."""
    from scipy.stats import chi2

    found = []
    for where, slow in _channels(point):
        for count in (each for each in SLOWEST if each <= slow.size):
            total = float(np.sum(slow[:count] ** 2))
            found.append(Slow(where, total - count, float(chi2.sf(total, count))))
    if not found:
        return None
    least = min(found, key=lambda each: each.chance)
    least = replace(least, chance=min(1.0, least.chance * len(found)))
    return least if least.chance < CHANCE else None


def _channels(point: Point) -> Iterator[tuple[str, np.ndarray]]:
    """Name of each channel of each group, and components of what is left of it, slowest first."""
    from scipy.fft import dct

    start = 0
    for group in point.ground.model.groups:
        for name in group.names:
            left = point.miss[start : start + group.bins]
            start += group.bins
            yield f"the {name} of {group.entries[0].name}", dct(left, norm="ortho")
