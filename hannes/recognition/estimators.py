"""Recognition as scikit-learn estimators: a sample is a grasp, of which features make many windows.

    pipeline = Pipeline([("features", WindowFeatures()), ("trees", BaggedTrees())])
    GridSearchCV(pipeline, {"features__window": [0.03, 0.05], "trees__leaf": [5, 20]}).fit(X, y)

X: shape (grasps, samples, 3), of current [A], position and reference [rad], or a list of
recordings; y: 1 for a rigid object, 0 for a soft one.
"""

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin, TransformerMixin

from hannes.core.errors import BadInput
from hannes.recognition.bagging import Rows, bagged
from hannes.recognition.features import NAMES
from hannes.recognition.windowing import Samples, Windowing

SINCE = NAMES.index("since")


class WindowFeatures(TransformerMixin, BaseEstimator):
    """Recordings to causal features of their windows, shape (grasps, windows, features), float32.

    `window`, `hop`: length and distance of windows [s]; `sampling` [Hz]: recordings of another
    are interpolated. Where a grasp has no window (it ended before, or too little was seen) all
    features are NaN.
    """

    def __init__(self, window: float = 0.05, hop: float = 0.01, sampling: float = 1000.0) -> None:
        self.window, self.hop, self.sampling = window, hop, sampling

    def fit(self, X: Samples, y: Any = None) -> Self:
        """Nothing is trained; BadInput for parameters that cannot be used."""
        self.windowing_ = Windowing(self.window, self.hop, self.sampling)
        return self

    def transform(self, X: Samples) -> np.ndarray:
        """Features of each window of each grasp."""
        return Windowing(self.window, self.hop, self.sampling).features(X)

    def get_feature_names_out(self, input_features: Any = None) -> np.ndarray:
        """Names of the last axis."""
        return np.array(NAMES, object)

    def __sklearn_is_fitted__(self) -> bool:
        return True


class BaggedTrees(ClassifierMixin, BaseEstimator):
    """Bagged decision trees, each split among a random choice of features; a vote a window.

    `trees`: how many; `leaf`: least windows of a leaf; `share`: of the windows of its grasps that a
    tree learns from; `seed`; `jobs`: as joblib's. A grasp's probability is the mean over its
    windows.
    """

    def __init__(
        self,
        trees: int = 100,
        leaf: int = 20,
        share: float = 0.5,
        seed: int = 0,
        jobs: int | None = None,
    ) -> None:
        self.trees, self.leaf, self.share, self.seed, self.jobs = trees, leaf, share, seed, jobs

    def fit(self, X: np.ndarray, y: Sequence[int] | np.ndarray, scored: Any = None) -> Self:
        """Learn from features (grasps, windows, features) and a class a grasp, 0 or 1.

        `scored` (grasps, windows) says which windows to learn from; default: those after a touch.
        """
        labels = np.asarray(y).astype(int)
        if set(np.unique(labels)) - {0, 1}:
            raise BadInput("expected the classes 0 (soft) and 1 (rigid)")
        used = touched(X) if scored is None else np.asarray(scored) & ~np.isnan(X[..., 0])
        owner = np.nonzero(used)[0]
        classes = labels[owner].astype(float)
        if np.unique(classes).size < 2:
            raise BadInput("expected windows of soft and of rigid objects to learn from")
        self.classes_ = np.array([0, 1])
        rows = Rows(X[used], classes, np.ones(owner.size), owner)
        how = {"min_samples_leaf": self.leaf, "max_features": "sqrt"}
        self.bagged_ = bagged(
            rows, labels.size, self.trees, self.share, self.seed, self.jobs, **how
        )
        self.forest_ = self.bagged_.forest()
        return self

    def window_proba(self, X: np.ndarray) -> np.ndarray:
        """Probability of rigid in each window, shape (grasps, windows); NaN where there is none."""
        known = ~np.isnan(X[..., 0])
        predicted = np.full(X.shape[:2], np.nan)
        if known.any():
            predicted[known] = self.forest_(X[known])
        return predicted

    def predict_proba(self, X: np.ndarray) -> np.ndarray:
        """Probability of soft and of rigid for each grasp, shape (grasps, 2)."""
        weights = touched(X).astype(float)
        total = (np.nan_to_num(self.window_proba(X)) * weights).sum(axis=1)
        rigid = np.where(weights.any(axis=1), total / np.maximum(weights.sum(axis=1), 1.0), 0.5)
        return np.stack([1.0 - rigid, rigid], axis=1)

    def predict(self, X: np.ndarray) -> np.ndarray:
        """0 or 1 for each grasp."""
        return (self.predict_proba(X)[:, 1] >= 0.5).astype(int)


def touched(X: np.ndarray) -> np.ndarray:
    """Which windows come after a touch, shape (grasps, windows)."""
    return np.nan_to_num(X[..., SINCE]) > 0.0
