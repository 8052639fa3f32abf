"""Bagged trees whose bags are of whole grasps.

Windows of one grasp resemble each other, so a bag of windows leaves nothing unseen. A bag of
grasps leaves the others unseen. Predictions of trees for grasps outside their bags measure the
model, with nothing withheld from training (out-of-bag estimates, Breiman 1996).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.recognition.forest import QUANTILES, Forest, of_sklearn

SHARE = 0.632  # of the grasps that a tree learns from: what a bootstrap would draw


@dataclass(frozen=True)
class Rows:
    """Training windows: features (m, features), target and weight (m,), grasp of each (m,)."""

    features: np.ndarray
    target: np.ndarray
    weight: np.ndarray
    owner: np.ndarray


@dataclass(frozen=True)
class Bagged:
    """Fitted regression trees of scikit-learn; `seen`: grasps in each bag, (trees, grasps).

    `jobs` as joblib's: how many of them predict at once.
    """

    trees: list[Any]
    seen: np.ndarray
    jobs: int | None = 1

    def forest(self) -> Forest:
        """All trees as plain arrays."""
        return of_sklearn(self.trees)

    def mean_unseen(self, rows: np.ndarray, owner: np.ndarray) -> np.ndarray:
        """Mean over trees that have not seen the grasp of a row (m, features), shape (m,)."""
        total, count = np.zeros(len(rows)), np.zeros(len(rows))
        for apart, predicted in self._unseen(rows, owner):
            total[apart] += predicted
            count[apart] += 1.0
        return total / np.where(count > 0.0, count, np.nan)

    def quantiles_unseen(self, rows: np.ndarray, owner: np.ndarray) -> np.ndarray:
        """The same, QUANTILES over trees, shape (m, 3)."""
        every = np.full((len(self.trees), len(rows)), np.nan)
        for tree, (apart, predicted) in zip(every, self._unseen(rows, owner), strict=True):
            tree[apart] = predicted
        return _quantiles(every)

    def _unseen(
        self, rows: np.ndarray, owner: np.ndarray
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        from joblib import Parallel, delayed

        from hannes.core.io.progress import progress_bar

        rows = np.ascontiguousarray(rows, np.float32)
        judging = Parallel(n_jobs=self.jobs, prefer="threads", return_as="generator")(
            delayed(_judged)(tree, ~seen[owner], rows)
            for tree, seen in zip(self.trees, self.seen, strict=True)
        )
        yield from progress_bar(judging, "judging trees", len(self.trees), delay=2.0, leave=False)


def bagged(
    rows: Rows, grasps: int, trees: int, thin: float, seed: int, jobs: int | None, **how: Any
) -> Bagged:
    """Trees that each learn from some of `grasps`, and from a share `thin` of their windows.

    how: further arguments of scikit-learn's DecisionTreeRegressor. Of targets 0 and 1 such a tree
    is the classifier that splits by Gini's impurity, which is twice their variance.
    """
    from joblib import Parallel, delayed

    from hannes.core.io.progress import progress_bar

    seeds = np.random.SeedSequence(seed).spawn(trees)
    growing = Parallel(n_jobs=jobs, prefer="threads", return_as="generator")(
        delayed(_grown)(rows, grasps, thin, each, how) for each in seeds
    )
    found = list(progress_bar(growing, "growing trees", trees, delay=2.0, leave=False))
    return Bagged([tree for tree, _ in found], np.array([seen for _, seen in found]), jobs)


def _quantiles(every: np.ndarray) -> np.ndarray:
    """QUANTILES of what is no NaN in each column (trees, m), shape (m, 3); NaN where nothing is."""
    count = np.isfinite(every).sum(axis=0)
    every.sort(axis=0)  # NaN last
    place = np.outer(QUANTILES, np.maximum(count - 1, 0))
    low = place.astype(int)
    high = np.minimum(low + 1, np.maximum(count - 1, 0))
    below, above = (np.take_along_axis(every, which, axis=0) for which in (low, high))
    return (below + (place - low) * (above - below)).T


def _judged(tree: Any, apart: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which rows (float32) a tree predicts, and its predictions for these."""
    found = tree.tree_.predict(rows[apart])[:, 0] if apart.any() else np.zeros(0)
    return apart, found


def _grown(
    rows: Rows, grasps: int, thin: float, seed: np.random.SeedSequence, how: dict[str, Any]
) -> tuple[Any, np.ndarray]:
    from sklearn.tree import DecisionTreeRegressor

    rng = np.random.default_rng(seed)
    seen = np.zeros(grasps, bool)
    seen[rng.permutation(grasps)[: max(1, round(SHARE * grasps))]] = True
    some = np.flatnonzero(seen[rows.owner])
    if thin < 1.0:
        some = np.sort(rng.permutation(some)[: max(1, round(thin * some.size))])
    tree = DecisionTreeRegressor(random_state=int(rng.integers(2**31)), **how)
    tree.fit(rows.features[some], rows.target[some], rows.weight[some])
    return tree, seen
