"""A smooth curve through what was learnt: the mean of a Gaussian process, as plain arrays.

Trees tell of a grasp what a few of those that were learnt had. A force that rises smoothly with a
current is told more finely by all of them together, each the more the more alike it is.
"""

from dataclasses import dataclass

import numpy as np

from hannes.errors import BadInput

CLIP = 3.0  # deviations from the middle: what lies further out is taken to lie there
NOISE = 0.02  # of the variance of what is learnt, and not told by the features
FEWEST, MOST = 50, 9000  # grasps to learn from: 2 GB of memory
SAMPLE = 500  # of them, by which the length is chosen
FOLDS = 3
MOST_POINTS = 100_000
SMALLEST, LARGEST = 1e-9, 1e9  # of values in a model, which any real one stays far within


@dataclass(frozen=True)
class Smooth:
    """Features as deviations from `middle` by `spread`; `points` (n, features), their `weight`.

    Two points d apart are alike by 1 / (1 + d^2 / (2 length^2)), the rational quadratic covariance
    (Rasmussen and Williams 2006, equation 4.19, exponent 1). `mean` is of what was learnt, and
    nothing is told beyond `ends`, the least and the most of it.
    """

    middle: np.ndarray
    spread: np.ndarray
    points: np.ndarray
    weight: np.ndarray
    length: np.ndarray
    mean: np.ndarray
    ends: np.ndarray

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """What is told of rows of features (m, features), shape (m,)."""
        told = [self._of(point) for point in standard(rows, self.middle, self.spread)]
        return np.clip(np.array(told), *self.ends)

    def _of(self, point: np.ndarray) -> float:
        away = np.square(self.points - point).sum(axis=1, dtype=float)
        return float(self.mean[0] + self.weight @ (1.0 / (1.0 + away / (2.0 * self.length**2))))

    def check(self, features: int) -> "Smooth":
        """Return itself where shapes fit and values can be reckoned with; BadInput otherwise."""
        for name, shape in self._shapes(features).items():
            values = getattr(self, name)
            if values.shape != shape:
                raise BadInput(f"peak/{name}: shape {values.shape}, expected {shape}")
            if not (np.abs(values) <= LARGEST).all():
                raise BadInput(f"peak/{name}: a value is not finite, or beyond {LARGEST:g}")
        if min(self.spread.min(), self.length[0]) < SMALLEST or self.ends[0] > self.ends[1]:
            raise BadInput("peak: spread, length or ends are out of order")
        return self

    def _shapes(self, features: int) -> dict[str, tuple[int, ...]]:
        one, points = (features,), (self.weight.size, features)
        shapes = {"middle": one, "spread": one, "points": points, "weight": points[:1]}
        return shapes | {"length": (1,), "mean": (1,), "ends": (2,)}


FIELDS = {
    name: np.dtype("<f4" if name == "points" else "<f8") for name in Smooth.__dataclass_fields__
}


def standard(rows: np.ndarray, middle: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Rows as points, float32."""
    return np.clip((rows - middle) / spread, -CLIP, CLIP).astype(np.float32)


def learnt(rows: np.ndarray, target: np.ndarray, seed: int) -> tuple[Smooth, np.ndarray]:
    """The curve through rows (n, features) of targets (n,): the mean of FOLDS, each of the others'.

    Beside it what is told of each row by the curve that has not learnt from it, shape (n,). Of
    more than MOST rows, those beyond are told of by all and learnt from by none.
    """
    from sklearn.model_selection import KFold

    middle, spread = np.median(rows, axis=0), rows.std(axis=0)
    spread[spread == 0.0] = 1.0
    some = np.random.default_rng(seed).permutation(target.size)[:MOST]
    points, known = standard(rows[some], middle, spread), target[some]
    process, weight, mean = _process(points), np.zeros(some.size), 0.0
    unseen = np.empty(target.size)
    for others, part in KFold(FOLDS).split(points):
        process.fit(points[others], known[others])
        unseen[some[part]] = process.predict(points[part])
        weight[others] += process.alpha_ * known[others].std() / FOLDS
        mean += known[others].mean() / FOLDS
    ends = np.array([target.min(), target.max()])
    length = np.array([process.kernel_.length_scale])
    made = Smooth(middle, spread, points, weight, length, np.array([mean]), ends)
    rest = np.setdiff1d(np.arange(target.size), some)
    unseen[rest] = made(rows[rest])
    return made, np.clip(unseen, *ends)


def _process(points: np.ndarray):  # type: ignore[no-untyped-def]  # of a library imported late
    """A Gaussian process that is yet to learn; its length by how far points lie apart."""
    from scipy.spatial.distance import pdist
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RationalQuadratic

    length = float(np.sqrt(0.5 * np.median(pdist(points[:SAMPLE], "sqeuclidean"))))
    likeness = RationalQuadratic(length, alpha=1.0)
    return GaussianProcessRegressor(likeness, alpha=NOISE, optimizer=None, normalize_y=True)
