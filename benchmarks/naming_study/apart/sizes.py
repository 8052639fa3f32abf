"""How large an effect may be drawn: from twice what an oracle sees up to the end of its range.

Twice u, or the low end of the range where that is more, up to the high end: log-uniform, as many
from each third of that range in logarithms. A user who states nothing has the sizes of the poor
protocol: the oracle knows the truth, whoever records.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.naming_study.frozen import smallest
from benchmarks.oracle import APART
from benchmarks.oracle.shapes import shapes
from benchmarks.truth.hidden import SIZES

CLEAR = 2.0  # times u, at least
THIRDS = 3
STREAM = 52  # of random numbers


@dataclass(frozen=True)
class Range:
    """Magnitudes (SI) of one sign that an amplitude may have beside a shape; u: None unknown."""

    name: str
    shape: Mapping[str, float]
    u: float | None
    sign: float
    low: float
    high: float

    def at(self, share: float) -> float:
        """The signed size at a share, 0 to 1, of the range in logarithms."""
        return self.sign * self.low * (self.high / self.low) ** share


def named(protocol: str) -> dict[str, list[Range]]:
    """By full name: ranges of all that has a name, where something of it is clear enough."""
    found = {
        name: [each for s in known if s.u is not None for each in _ranges(name, s.shape, s.u)]
        for name, known in smallest(protocol, APART).items()
    }
    return {name: ranges for name, ranges in found.items() if ranges}


def outside(effects: Sequence[str]) -> dict[str, list[Range]]:
    """By full name: whole ranges of effects that no catalogue has, whose u nobody asked."""
    names = [n for n, s in SIZES.items() if s.amplitude and n.partition(".")[0] in effects]
    return {n: [each for s in shapes(n) for each in _ranges(n, s, None)] for n in names}


def _ranges(name: str, shape: Mapping[str, float], u: float | None) -> list[Range]:
    found = []
    for sign, least, most in SIZES[name].signs.values():
        low = max(least, CLEAR * u) if u is not None else max(least, 0.02 * most)
        if low < most:
            found.append(Range(name, shape, u, sign, low, most))
    return found


def share(rng: np.random.Generator, third: int | None) -> float:
    """A share of a range, of one third of it or of any."""
    return float(rng.uniform() if third is None else (third + rng.uniform()) / THIRDS)


def third(seed: int, place: int, number: int = 0) -> int:
    """Which third a case's size is of; three cases that follow each other have all of them.

    number: of several effects of a case, which
    """
    first = np.random.default_rng([seed - place % THIRDS, STREAM, 1, number])
    return int(first.permutation(THIRDS)[place % THIRDS])


def turn(names: Sequence[str], first: int, place: int) -> str:
    """The name that a case's turn has: all come up before one comes up again, in any order.

    first: seed of the kind's first case
    """
    rng = np.random.default_rng([first, STREAM, 2, place // len(names)])
    return str(rng.permutation(sorted(names))[place % len(names)])
