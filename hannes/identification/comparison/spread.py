"""Mean and standard deviations over repeats and over several units of a machine."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Spread:
    """A metric over runs: `repeats` and `units` are standard deviations, None where unknown.

    mean:    of the units' means, so that each unit counts alike
    repeats: of runs about the mean of their unit, pooled; needs two runs of one unit
    units:   of the units' means, as the paper's 0.25 +- 0.03 A of four hands; needs two units
    """

    mean: float
    repeats: float | None
    units: float | None
    runs: int


def spread(values: Mapping[str, Sequence[float]]) -> Spread:
    """Return mean and spreads of `values`, one or more of each unit."""
    means = np.array([np.mean(each) for each in values.values()])
    runs = sum(len(each) for each in values.values())
    apart = np.concatenate([np.subtract(each, np.mean(each)) for each in values.values()])
    free = runs - means.size
    return Spread(
        float(means.mean()),
        float(np.sqrt((apart**2).sum() / free)) if free else None,
        float(means.std(ddof=1)) if means.size > 1 else None,
        runs,
    )
