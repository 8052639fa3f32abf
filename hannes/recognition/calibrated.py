"""What a model's answers proved to be worth on grasps that it had not learnt from."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from hannes.recognition.grasps import Grasps, held
from hannes.recognition.model import Band, Calibration, Model, grasp_peak, grasp_stiffness

BINS = 6  # of an interval's width along the estimate
FOLDS = 5
GRID, WIDTH = np.round(np.arange(0.5, 0.71, 0.01), 2), 0.02  # of confidence


@dataclass(frozen=True)
class Answers:
    """What a model tells of n grasps that it has not learnt from.

    rigid: of its forest, by window, NaN where it is not scored, shape (n, windows); stiffness [N/m]
    and peak force [N], shape (n,), NaN where nothing was held.
    """

    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray


def answers(model: Model, known: Grasps) -> Answers:
    """What `model` tells of grasps."""
    rigid = np.full(known.scored.shape, np.nan)
    rigid[known.scored] = model.rigid(known.features[known.scored])
    return Answers(rigid, *estimates(model, known))


def joined(parts: Sequence[Answers], places: Sequence[np.ndarray]) -> Answers:
    """Answers on parts of some grasps as those on all; `places` say which each part is of."""
    order = np.argsort(np.concatenate(places))
    names = [each.name for each in fields(Answers)]
    return Answers(*(np.concatenate([getattr(p, name) for p in parts])[order] for name in names))


def calibrated(model: Model, known: Grasps, told: Answers) -> Model:
    """The model with its probabilities and intervals as they proved on grasps not learnt from."""
    used = known.scored
    raw = told.rigid[used]
    classes = np.repeat(known.rigid, used.sum(axis=1)).astype(float)
    if np.unique(classes).size == 2:
        points = _isotonic(raw, classes)
        owner = np.repeat(np.arange(known.rigid.size), used.sum(axis=1))
        model = replace(model, calibration=points, sure=least_sure(raw, classes, owner))
    return replace(
        model,
        stiffness_band=_band(told.stiffness, known.stiffness),
        force_band=_band(told.peak, known.peak),
    )


def _isotonic(raw: np.ndarray, classes: np.ndarray) -> Calibration:
    from sklearn.isotonic import IsotonicRegression

    fitted = IsotonicRegression(y_min=0.005, y_max=0.995).fit(raw, classes)
    return Calibration(fitted.X_thresholds_.astype(float), fitted.y_thresholds_.astype(float))


def least_sure(raw: np.ndarray, classes: np.ndarray, owner: np.ndarray) -> float:
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
            peak[k] = grasp_peak(model.force.median(rows), some)
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
