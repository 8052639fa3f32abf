"""`hannes train`: learn from a data set's grasps; some of them are kept to say what it is worth."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes.dataset.read import DataSet, read
from hannes.errors import BadInput
from hannes.recognition.cut import Cut
from hannes.recognition.features import CHANNELS
from hannes.recognition.forest import of_sklearn
from hannes.recognition.model import (
    HELD,
    RISE,
    SINCE,
    Band,
    Calibration,
    Model,
    decided,
    grasp_stiffness,
    running,
)

WEAKEST = 5.0  # N: an object that was held with less was hardly grasped
KEPT = 0.2  # share of the grasps that is not learnt from
LEAST = 0.5  # N, of the force that is learnt
FEWEST = 30  # grasps of a learning curve
BINS = 6  # of an interval's width along the estimate
FOLDS = 5
GRID, WIDTH = np.round(np.arange(0.5, 0.71, 0.01), 2), 0.02  # of confidence


@dataclass(frozen=True)
class Grasps:
    """Features (n, windows, features), what is known of each grasp, and its force by window [N]."""

    features: np.ndarray
    force: np.ndarray
    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray
    scored: np.ndarray

    def some(self, which: np.ndarray) -> "Grasps":
        return Grasps(*(each[which] for each in vars(self).values()))


def scored(times: np.ndarray, cut: Cut, contact: np.ndarray, release: np.ndarray) -> np.ndarray:
    """Which windows lie between contact and release, shape (grasps, windows).

    A feature looks back over two lengths: both must lie inside.
    """
    begun = times - 2.0 * cut.window
    return (begun >= contact[:, np.newaxis]) & (times <= release[:, np.newaxis])


def grasps(data: DataSet, which: np.ndarray, cut: Cut) -> Grasps:
    """Read the grasps `which` (bool); BadInput where there are none."""
    rows = np.flatnonzero(which & data.usable & (data.table["peak_force"] > WEAKEST))
    if not rows.size:
        raise BadInput(f"{data.path}: no grasp of these holds its object")
    rate = 1.0 / float(np.median(np.diff(data.time)))
    if abs(rate / cut.sampling - 1.0) > 1e-6:
        raise BadInput(f"{data.path}: sampled at {rate:g} Hz, expected {cut.sampling:g} Hz")
    features, force = [], []
    ends = cut.ends(data.time.size) - 1
    for block in data.blocks(rows, (*CHANNELS, "force")):
        features.append(cut.features(block[..., :3]))
        force.append(block[:, ends, 3])
    table = data.table[rows]
    inside = scored(cut.times(data.time.size), cut, table["contact"], table["release"])
    known = (data.rigid[rows], table["object.stiffness"], table["peak_force"], inside)
    return Grasps(np.concatenate(features), np.concatenate(force), *known)


def train(
    path: str | Path,
    *,
    trees: int = 100,
    seed: int = 0,
    cut: Cut | None = None,
    jobs: int | None = -1,
    most: int | None = None,
) -> tuple[Model, dict[str, Any]]:
    """Learn from a data set; the model, and what it is worth on grasps it has not seen.

    A fifth of the grasps for training is kept for calibration and intervals. `most` grasps are
    learnt from where that is given. Grasps of the role "test" are only reported on.
    """
    data, cut = read(path), cut or Cut()
    known = grasps(data, data.role("train"), cut)
    kept = _kept(known, seed)
    learnt = np.flatnonzero(~kept)[:most]
    model = _learnt(known, kept, learnt, data, cut, trees, seed, jobs)
    told = {"title": data.title, "grasps": int(learnt.size), "kept": int(kept.sum())}
    if kept.any():
        told["kept_scores"] = worth(model, known.some(kept))
    if data.role("test").any():
        told["test_scores"] = worth(model, grasps(data, data.role("test"), cut))
    return model, told


def curve(
    path: str | Path, *, trees: int = 40, seed: int = 0, jobs: int | None = -1
) -> Iterator[tuple[int, Model]]:
    """Models that learnt from ever more grasps, and from how many: a learning curve.

    From all that `train` learns from down to a quarter, a quarter of that, and so on to some 30;
    calibrated on the same grasps that are kept.
    """
    data, cut = read(path), Cut()
    known = grasps(data, data.role("train"), cut)
    kept = _kept(known, seed)
    order = np.flatnonzero(~kept)
    steps = 1 + max(0, int(np.log(order.size / FEWEST) / np.log(4.0)))
    for count in [round(order.size / 4.0**k) for k in range(steps)][::-1]:
        yield count, _learnt(known, kept, order[:count], data, cut, trees, seed, jobs)


def _kept(known: Grasps, seed: int) -> np.ndarray:
    """Which grasps are not learnt from; none of a design by hand, which has none to spare."""
    size, rng = known.rigid.size, np.random.default_rng(seed)
    return (rng.permutation(size) < round(KEPT * size)) & (size >= 50)


def _learnt(
    known: Grasps, kept: np.ndarray, learnt: np.ndarray, data: DataSet, cut: Cut,
    trees: int, seed: int, jobs: int | None,
) -> Model:  # fmt: skip
    model = _fitted(known.some(learnt), cut, data, trees, seed, jobs)
    return _calibrated(model, known.some(kept) if kept.any() else known)


def _fitted(
    known: Grasps, cut: Cut, data: DataSet, trees: int, seed: int, jobs: int | None
) -> Model:
    from sklearn.ensemble import RandomForestRegressor

    from hannes.recognition.estimators import BaggedTrees

    used = known.scored | held(known.features)
    few = used.sum() < 5000
    leaf, share = (2, 1.0) if few else (20, 0.3)
    bag = BaggedTrees(trees, leaf, share, seed, jobs)
    rigid = bag.fit(known.features, known.rigid.astype(int), used).arrays()

    def regression(which: np.ndarray, target: np.ndarray) -> Any:
        how = {"min_samples_leaf": leaf, "max_samples": share / 2, "max_features": 0.4}
        made = RandomForestRegressor(max(trees // 2, 10), random_state=seed, n_jobs=jobs, **how)
        return of_sklearn(made.fit(known.features[which], target))

    stiffness = np.broadcast_to(np.log(known.stiffness)[:, np.newaxis], used.shape)
    pressed = used & (known.force > LEAST)
    nothing = np.zeros(1)
    return Model(
        cut,
        data.border,
        0.5,
        rigid,
        regression(used, stiffness[used]),
        regression(pressed, np.log(known.force[pressed])),
        Calibration(np.array([0.0, 1.0]), np.array([0.0, 1.0])),
        Band(nothing, nothing, nothing),
        Band(nothing, nothing, nothing),
        trained=f"{data.title}; fingerprint {data.digest}; seed {seed}",
    )


def held(features: np.ndarray) -> np.ndarray:
    """Windows in which an object is held, as far as the features tell."""
    return (np.nan_to_num(features[..., SINCE]) > 0.0) & (features[..., RISE] > HELD)


def last_held(features: np.ndarray) -> np.ndarray:
    """Last window of each grasp in which its object is held, -1 where there is none."""
    found = held(features)
    last = found.shape[1] - 1 - np.argmax(found[:, ::-1], axis=1)
    return np.where(found.any(axis=1), last, -1)


def _calibrated(model: Model, known: Grasps) -> Model:
    """The model with its probabilities and intervals as they proved on grasps not learnt from."""
    used = known.scored
    raw = model.rigid(known.features[used])
    classes = np.repeat(known.rigid, used.sum(axis=1)).astype(float)
    if np.unique(classes).size == 2:
        points = _isotonic(raw, classes)
        owner = np.repeat(np.arange(known.rigid.size), used.sum(axis=1))
        model = replace(model, calibration=points, sure=_sure(raw, classes, owner))
    stiffness, peak = estimates(model, known)
    return replace(
        model,
        stiffness_band=_band(stiffness, known.stiffness),
        force_band=_band(peak, known.peak),
    )


def _isotonic(raw: np.ndarray, classes: np.ndarray) -> Calibration:
    from sklearn.isotonic import IsotonicRegression

    fitted = IsotonicRegression(y_min=0.005, y_max=0.995).fit(raw, classes)
    return Calibration(fitted.X_thresholds_.astype(float), fitted.y_thresholds_.astype(float))


def _sure(raw: np.ndarray, classes: np.ndarray, owner: np.ndarray) -> float:
    """Probability from which a decision beats a coin, by cross-validation over grasps.

    raw: what the forest told of windows; owner: the grasp of each. It is the least confidence on
    a grid at which the windows told about so are right more often than half, at 95 % confidence.
    """
    told = np.full(raw.size, 0.5)
    for fold in range(FOLDS):
        out = owner % FOLDS == fold
        if np.unique(classes[~out]).size == 2 and out.any():
            told[out] = _isotonic(raw[~out], classes[~out])(raw[out])
    confidence, right = np.maximum(told, 1.0 - told), (told >= 0.5) == classes
    for sure in GRID:
        about = (confidence >= sure) & (confidence < sure + WIDTH)
        if about.any() and _least_share(right[about], owner[about]) > 0.5:
            return float(sure)
    return float(GRID[-1])


def _least_share(right: np.ndarray, owner: np.ndarray) -> float:
    """Lower end of the one-sided 95 % interval of a share, windows of a grasp taken together."""
    share = right.mean()
    off = np.bincount(owner, right - share)
    return float(share - 1.645 * np.sqrt((off**2).sum()) / right.size)


def estimates(model: Model, known: Grasps) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness [N/m] and peak force [N] of each grasp, NaN where nothing was held."""
    stiffness, peak = np.full(known.rigid.size, np.nan), np.full(known.rigid.size, np.nan)
    for k, (rows, some) in enumerate(zip(known.features, held(known.features), strict=True)):
        if some.any():
            stiffness[k] = grasp_stiffness(model.stiffness(rows), some)
            peak[k] = np.exp(model.force(rows[some])).max()
    return stiffness, peak


def _band(estimate: np.ndarray, true: np.ndarray) -> Band:
    """Where the truth lies about an estimate, from 2.5 to 97.5 %, along the estimate."""
    found = np.isfinite(estimate)
    at, off = np.log(estimate[found]), np.log(true[found] / estimate[found])
    bins = min(BINS, max(1, at.size // 40))
    order = np.argsort(at)
    parts = [part for part in np.array_split(order, bins) if part.size]
    ends = np.array([np.percentile(off[part], (2.5, 97.5)) for part in parts])
    return Band(np.array([at[part].mean() for part in parts]), *ends.T.copy())


def worth(model: Model, known: Grasps) -> dict[str, float]:
    """Shares of right decisions, and errors, on grasps that were not learnt from."""
    there = ~np.isnan(known.features[..., 0])
    rigid = np.full(there.shape, 0.5)
    rigid[there] = model.windows(known.features[there])
    windows = decided(rigid, model.sure) == known.rigid[:, np.newaxis]
    last = last_held(known.features)
    touched = np.nan_to_num(known.features[..., SINCE]) > 0.0
    whole = running(rigid, touched, model.cut.hop)[np.arange(last.size), last]
    grasp = decided(whole, model.sure) == known.rigid
    stiffness, peak = estimates(model, known)
    miss = np.abs(peak / known.peak - 1.0)
    return {
        "grasps": int(known.rigid.size),
        "windows_right": float(windows[known.scored].mean()),
        "grasps_right": float(grasp[last >= 0].mean()),
        "brier": float(np.mean((rigid - known.rigid[:, np.newaxis])[known.scored] ** 2)),
        "stiffness_factor": float(
            np.exp(np.nanmedian(np.abs(np.log(stiffness / known.stiffness))))
        ),
        "peak_force_error_percent": float(100.0 * np.nanmedian(miss)),
    }
