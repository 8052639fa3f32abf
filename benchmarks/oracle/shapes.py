"""Where or how fast a hidden effect acts: an effect of another shape has another smallest size.

Drawn once, each range in equal parts, one shape from each (McKay, Beckman & Conover 1979). What a
study hides has one of these shapes.
"""

from collections.abc import Mapping

import numpy as np
from scipy.stats import qmc

from benchmarks.truth.hidden import SIZES
from benchmarks.truth.size import Size

COUNT, SEED = 5, 43
WHOLE = ("cycles", "joint", "finger")  # parameters that are counts
Shape = Mapping[str, float]  # by full name, SI


def shapes(amplitude: str) -> list[Shape]:
    """Shapes of the effect that an amplitude belongs to; one without values where it has none."""
    effect = amplitude.partition(".")[0]
    names = [n for n, s in SIZES.items() if n.partition(".")[0] == effect and not s.amplitude]
    if not names:
        return [{}]
    rng = np.random.default_rng([SEED, *effect.encode()])
    drawn = qmc.LatinHypercube(len(names), rng=rng).random(COUNT)
    return [{n: _at(n, SIZES[n], x) for n, x in zip(names, row, strict=True)} for row in drawn]


def shape_name(shape: Shape) -> str:
    """A shape as names of files have it."""
    return "".join(f",{name.partition('.')[2]}={value:g}" for name, value in shape.items())


def _at(name: str, size: Size, share: float) -> float:
    """The value at a share of a range, in no more figures than the frozen file has."""
    if name.partition(".")[2] in WHOLE:
        return float(np.floor(size.low + share * (size.high - size.low + 1.0)))
    ratio = size.high / size.low if size.low > 0.0 else None
    value = size.low * ratio**share if ratio else size.low + share * (size.high - size.low)
    return float(f"{value:.4g}")
