"""Sizes at which an effect is looked at in the machine as given, and what each would leave."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.score_test import amplitude_names
from hannes.identification.diagnosis.tuning import SEARCH

Looked = tuple[np.ndarray, np.ndarray]  # points, and chi-squared that each would leave


def looked_at_sizes(nominal: Linearisation, name: str, sizes: Sequence[float]) -> Looked:
    """Points with an effect at these sizes, and what each leaves, all else following."""
    rows = _sizes(nominal, name, sizes)
    return rows, left_at(nominal, name, rows)


def looked_at_between(nominal: Linearisation, name: str, looked: Looked) -> Looked:
    """The same with sizes about the best one, twice half way to its neighbours.

    What the finger of a fault touches makes a narrow valley.
    """
    rows, left = looked
    for _ in range(SEARCH.halvings if rows.size else 0):
        more = _about(rows, int(np.argmin(left)), nominal.x)
        rows, left = np.vstack([rows, more]), np.append(left, left_at(nominal, name, more))
    return rows, left


def _about(rows: np.ndarray, best: int, x: np.ndarray) -> np.ndarray:
    """Points between the best one of some rows and its neighbours of the same amplitude.

    Half way to each; shape (1 or 2, size), as the largest size has one neighbour.
    """
    place = int(np.argmax(np.abs(rows[best] - x)))
    alike = np.abs(rows - x).argmax(axis=1) == place
    sizes = np.unique(np.append(rows[alike, place], x[place]))
    here = int(np.searchsorted(sizes, rows[best, place]))
    beside = [sizes[k] for k in (here - 1, here + 1) if 0 <= k < sizes.size]
    found = np.repeat(x[np.newaxis], len(beside), axis=0)
    found[:, place] = 0.5 * (rows[best, place] + np.array(beside))
    return found


def left_at(nominal: Linearisation, name: str, rows: np.ndarray) -> np.ndarray:
    """Chi-squared at points with an effect, shape (m,), all else following linearly."""
    own = nominal.space.of(name)
    return nominal.with_active(np.union1d(nominal.active, own)).chi2_at(rows, following=True)


def _sizes(nominal: Linearisation, name: str, sizes: Sequence[float]) -> np.ndarray:
    """Points with each amplitude of an effect at each size inside its range, (m, size).

    sizes: in steps, tried both ways
    """
    space = nominal.space
    rows = []
    for place in (space.place(each) for each in amplitude_names(space.effects[name])):
        for size in (*sizes, *np.negative(sizes)):
            if space.low[place] <= nominal.x[place] + size <= space.high[place]:
                rows.append(nominal.x + size * (np.arange(space.size) == place))
    return np.array(rows).reshape(-1, space.size)
