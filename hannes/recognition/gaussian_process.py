"""Gaussian processes for the peak force: their mean, as plain arrays.

Trees predict from a few similar training grasps. A force that rises smoothly with current is
predicted more finely from all of them, weighted by similarity.
"""

from dataclasses import dataclass, fields

import numpy as np

from hannes.core.errors import BadInput

CLIP = 3.0  # scales from the centre: points further out are clipped
CONSTANT = 1e-5  # of a feature's size: less variation is rounding, without information
NOISE = 0.02  # of the variance of the target, not explained by the features
JITTER = 1e-8  # of the variance, lest equal rows leave the covariance without a root
FEWEST, MOST = 50, 9000  # training grasps
INDUCING = 1500  # of them stand for all: a tenth of the time, forces as near
FOLDS = 3
MOST_POINTS = 100_000
SMALLEST, LARGEST = 1e-9, 1e9  # of values in a model, which any real one stays far within


@dataclass(frozen=True)
class ProcessMean:
    """Mean over FOLDS Gaussian processes of one covariance, each trained on the others' rows.

    `points` (n, features) are features less `centre`, over `scale`, of the grasps that stand for
    all; two of them d apart have covariance 1 / (1 + d^2 / (2 length^2)), rational quadratic
    (Rasmussen and Williams 2006, equation 4.19, exponent 1), times the `weight` (n,) of one.
    `mean` is that of the target, and predictions are clipped to `ends`, its least and its most.
    """

    centre: np.ndarray
    scale: np.ndarray
    points: np.ndarray
    weight: np.ndarray
    length: np.ndarray
    mean: np.ndarray
    ends: np.ndarray

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Predictions for rows of features (m, features), shape (m,)."""
        predicted = [self._of(point) for point in standard(rows, self.centre, self.scale)]
        return np.clip(np.array(predicted), *self.ends)

    def _of(self, point: np.ndarray) -> float:
        away = np.square(self.points - point).sum(axis=1, dtype=float)
        covariance = 1.0 / (1.0 + away / (2.0 * self.length**2))
        return float(self.mean[0] + self.weight @ covariance)

    def check(self, features: int) -> "ProcessMean":
        """Return itself where shapes and values are valid; BadInput otherwise."""
        for name, shape in self._shapes(features).items():
            values = getattr(self, name)
            if values.shape != shape:
                raise BadInput(f"peak/{name}: shape {values.shape}, expected {shape}")
            if not (np.abs(values) <= LARGEST).all():
                raise BadInput(f"peak/{name}: a value is not finite, or beyond {LARGEST:g}")
        if min(self.scale.min(), self.length[0]) < SMALLEST or self.ends[0] > self.ends[1]:
            raise BadInput("peak: scale, length or ends are out of order")
        return self

    def _shapes(self, features: int) -> dict[str, tuple[int, ...]]:
        one, points = (features,), (self.weight.size, features)
        shapes = {"centre": one, "scale": one, "points": points, "weight": points[:1]}
        return shapes | {"length": (1,), "mean": (1,), "ends": (2,)}


FIELDS = {
    each.name: np.dtype("<f4" if each.name == "points" else "<f8") for each in fields(ProcessMean)
}


def standard(rows: np.ndarray, centre: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Rows as points, float32."""
    return np.clip((rows - centre) / scale, -CLIP, CLIP).astype(np.float32)


def train_process(
    rows: np.ndarray, target: np.ndarray, seed: int
) -> tuple[ProcessMean, np.ndarray]:
    """Train on targets (n,) of rows (n, features); return the mean, and held-out predictions.

    The prediction for each row, shape (n,), is by the process that was not trained on it. Of more
    than MOST rows, those beyond are predicted by all and train none. `seed` chooses the rows. The
    same rows give the same values for any number of threads.
    """
    from threadpoolctl import threadpool_limits

    centre, scale = np.median(rows, axis=0), rows.std(axis=0)
    scale[scale <= CONSTANT * np.abs(rows).max(axis=0)] = LARGEST
    some = np.random.default_rng(seed).permutation(target.size)[:MOST]
    points, unseen = standard(rows[some], centre, scale), np.empty(target.size)
    length = float(np.sqrt(points.var(axis=0, dtype=float).sum())) or 1.0
    with threadpool_limits(1):  # sums of many threads end on other bits
        weight, mean, unseen[some] = _crossed(points, target[some], length)
    ends = np.array([target.min(), target.max()])
    one = (np.array([length]), np.array([mean]))
    made = ProcessMean(centre, scale, points[:INDUCING], weight, *one, ends)
    rest = np.setdiff1d(np.arange(target.size), some)
    unseen[rest] = made(rows[rest])
    return made, unseen


def _crossed(
    points: np.ndarray, target: np.ndarray, length: float
) -> tuple[np.ndarray, float, np.ndarray]:
    """Mean weights of the inducing points and mean of the folds' processes; held-out predictions.

    The first INDUCING points, drawn at random, stand for all: a process of the covariance that
    they project to (subset of regressors, Quinonero-Candela and Rasmussen 2005, section 5).
    Where they are all, it is the process itself.
    """
    from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
    from sklearn.gaussian_process.kernels import RationalQuadratic
    from sklearn.model_selection import KFold

    covariance, some = RationalQuadratic(length, alpha=1.0), points[:INDUCING]
    root = cholesky(covariance(some) + JITTER * np.eye(len(some)), lower=True)
    projected = solve_triangular(root, covariance(some, points), lower=True).T
    sizes, mean, unseen = np.zeros(len(some)), 0.0, np.empty(target.size)
    for others, part in KFold(FOLDS).split(points):
        known, middle = projected[others], target[others].mean()
        square = cho_factor(known.T @ known + NOISE * np.eye(len(some)))
        found = cho_solve(square, known.T @ (target[others] - middle))
        unseen[part] = middle + projected[part] @ found
        sizes += found / FOLDS
        mean += middle / FOLDS
    return solve_triangular(root.T, sizes), float(mean), unseen
