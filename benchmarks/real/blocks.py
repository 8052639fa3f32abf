"""How sure a figure of some recordings is: the figure of resampled blocks of them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

Block = Sequence[np.ndarray]  # several arrays of one length each: what is left, what was measured
Figure = Callable[[Sequence[float]], float]  # of the sum of squares of each

DRAWS = 2000


def squares(blocks: Sequence[Block]) -> np.ndarray:
    """Sums of squares, shape (blocks, arrays)."""
    return np.array([[float(each @ each) for each in block] for block in blocks])


def spread(sums: np.ndarray, figure: Figure) -> dict[str, float]:
    """95 % interval of a figure of the summed `sums`, blocks drawn with replacement."""
    rng = np.random.default_rng(0)
    drawn = rng.integers(0, len(sums), (DRAWS, len(sums)))
    values = [figure(sums[each].sum(axis=0)) for each in drawn]
    low, high = np.percentile(values, (2.5, 97.5))
    return {"low": float(low), "high": float(high)}


def row(name: str, sums: np.ndarray, figure: Figure) -> dict[str, Any]:
    """A figure under its name, with its interval."""
    return {"name": name, "value": figure(sums.sum(axis=0)), **spread(sums, figure)}
