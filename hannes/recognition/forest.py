"""Bagged trees as plain arrays, and their prediction compiled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.kernels.jit import entry, inner

MOST_TREES = 10_000
MOST_NODES = 20_000_000
QUANTILES = (0.1, 0.5, 0.9)  # over trees


@inner
def leaf(tree, starts, left, right, feature, threshold, value, row):
    """Value of the leaf of a tree that a row (features,) of float32 falls into.

    Node k of the tree that starts at s goes on at s + left[k] where the row's feature is at most
    the threshold, else at s + right[k]; a leaf has left[k] = -1.
    """
    start = starts[tree]
    node = start
    while left[node] >= 0:
        if row[feature[node]] <= threshold[node]:
            node = start + left[node]
        else:
            node = start + right[node]
    return value[node]


@entry
def mean(starts, left, right, feature, threshold, value, rows, out):
    """Fill `out` (m,) with the mean of the trees' predictions for rows (m, features)."""
    trees = starts.size - 1
    for row in range(rows.shape[0]):
        total = 0.0
        for tree in range(trees):
            total += leaf(tree, starts, left, right, feature, threshold, value, rows[row])
        out[row] = total / trees


@entry
def quantiles(starts, left, right, feature, threshold, value, rows, out):
    """Fill `out` (m, 3) with QUANTILES of the trees' predictions for rows (m, features)."""
    predicted = np.empty(starts.size - 1)
    for row in range(rows.shape[0]):
        for tree in range(predicted.size):
            predicted[tree] = leaf(tree, starts, left, right, feature, threshold, value, rows[row])
        predicted.sort()
        for k in range(3):
            place = QUANTILES[k] * (predicted.size - 1)
            low = int(place)
            high = min(low + 1, predicted.size - 1)
            out[row, k] = predicted[low] + (place - low) * (predicted[high] - predicted[low])


@dataclass(frozen=True)
class Forest:
    """Trees one after another; `starts` (trees + 1,) says where each begins; see `leaf`."""

    starts: np.ndarray
    left: np.ndarray
    right: np.ndarray
    feature: np.ndarray
    threshold: np.ndarray
    value: np.ndarray

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Mean over trees for rows (m, features), shape (m,): what scikit-learn predicts."""
        return self._over(mean, rows, (len(rows),))

    def quantiles(self, rows: np.ndarray) -> np.ndarray:
        """QUANTILES over trees for rows (m, features), shape (m, 3).

        Trees grown to a few samples spread as widely as the training targets of such rows, and a
        few that saw another kind do not shift their median (Meinshausen 2006).
        """
        return self._over(quantiles, rows, (len(rows), 3))

    def _over(self, across: Any, rows: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        out = np.empty(shape)
        rows = np.ascontiguousarray(rows, np.float32)
        across(*(getattr(self, name) for name in FIELDS), rows, out)
        return out

    def check(self, features: int) -> "Forest":
        """Return itself where every index stays inside and every path ends; BadInput otherwise."""
        starts, nodes = self.starts, self.left.size
        if not 1 <= starts.size - 1 <= MOST_TREES or not 1 <= nodes <= MOST_NODES:
            raise BadInput(f"{starts.size - 1} trees of {nodes} nodes in all are out of range")
        if any(getattr(self, name).shape != (nodes,) for name in NODES):
            raise BadInput("arrays of nodes are of unequal length")
        if starts[0] != 0 or starts[-1] != nodes or (np.diff(starts) < 1).any():
            raise BadInput("the trees' starts do not go from 0 up to the number of nodes")
        self._check_nodes(features)
        return self

    def _check_nodes(self, features: int) -> None:
        sizes = np.diff(self.starts)
        own = np.arange(self.left.size) - np.repeat(self.starts[:-1], sizes)
        size, inner = np.repeat(sizes, sizes), self.left != -1
        for side in (self.left[inner], self.right[inner]):  # children come after their parents
            if ((side <= own[inner]) | (side >= size[inner])).any():
                raise BadInput("a node leads out of its tree, or back")
        if ((self.feature[inner] < 0) | (self.feature[inner] >= features)).any():
            raise BadInput(f"a node asks for a feature that is not one of the {features}")
        if not (np.isfinite(self.threshold).all() and np.isfinite(self.value).all()):
            raise BadInput("a threshold or value is not finite")


def single(forest: Forest) -> Forest:
    """The same, its values rounded to single precision."""
    return replace(forest, value=forest.value.astype(np.float32).astype(float))


FIELDS: dict[str, np.dtype] = {
    "starts": np.dtype("<i8"),
    "left": np.dtype("<i4"),
    "right": np.dtype("<i4"),
    "feature": np.dtype("<i4"),
    "threshold": np.dtype("<f8"),
    "value": np.dtype("<f8"),
}
NODES = tuple(FIELDS)[1:]


def of_sklearn(fitted: Sequence[Any]) -> Forest:
    """The arrays of fitted regression trees of scikit-learn."""
    trees = [each.tree_ for each in fitted]
    sizes = [tree.node_count for tree in trees]
    joined = {
        "starts": np.concatenate([[0], np.cumsum(sizes)]),
        "left": np.concatenate([tree.children_left for tree in trees]),
        "right": np.concatenate([tree.children_right for tree in trees]),
        "feature": np.concatenate([np.maximum(tree.feature, 0) for tree in trees]),
        "threshold": np.concatenate([tree.threshold for tree in trees]),
        "value": np.concatenate([tree.value[:, 0, 0] for tree in trees]),
    }
    return Forest(**{name: joined[name].astype(kind) for name, kind in FIELDS.items()})
