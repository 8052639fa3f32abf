"""What a model's answers proved to be worth on grasps that it had not learnt from."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hannes.recognition.model import Band, Calibration, Model, grasp_peak, grasp_stiffness, held
from hannes.recognition.training_set import Grasps, last_held

BINS = 6  # of an interval's width
FOLDS = 5
Told = Callable[[np.ndarray, np.ndarray], np.ndarray]  # rows, grasp of each -> of each row
GRID, WIDTH = np.round(np.arange(0.5, 0.71, 0.01), 2), 0.02  # of confidence


@dataclass(frozen=True)
class Answers:
    """What is told of n grasps by what has not learnt from them.

    rigid: of the forest, by window, NaN where there is none, shape (n, windows); stiffness [N/m]
    and peak force [N], each with how far trees lie apart in its logarithm, shape (n, 2), NaN where
    nothing was held.
    """

    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray


def answers(model: Model, known: Grasps) -> Answers:
    """What `model` tells of grasps that it has not learnt from."""
    peak = model.peak
    return answered(
        known,
        lambda rows, owner: model.rigid(rows),
        lambda rows, owner: model.stiffness.quantiles(rows),
        lambda rows, owner: model.force.quantiles(rows),
        lambda rows, owner: peak(rows) if peak else np.full(len(rows), np.nan),
    )


def answered(
    known: Grasps, rigid: Told, log_stiffness: Told, log_force: Told, log_peak: Told
) -> Answers:
    """Answers from what is told of rows of features, and of which grasp each is.

    log_peak tells of rows of whole grasps; where that is NaN, or a grasp still held, log_force.
    """
    there, some = ~np.isnan(known.features[..., 0]), held(known.features)
    windows, logs = np.full(there.shape, np.nan), np.full((*some.shape, 3), np.nan)
    windows[there] = rigid(known.features[there], np.nonzero(there)[0])
    logs[some] = log_stiffness(known.features[some], np.nonzero(some)[0])
    stiffness, peak = (np.full((len(some), 2), np.nan) for _ in range(2))
    found, last = np.flatnonzero(some.any(axis=1)), last_held(known.features)
    stiffness[found] = [grasp_stiffness(logs[k][some[k]]) for k in found]
    peak[found] = [
        grasp_peak(each) for each in log_force(known.features[found, last[found]], found)
    ]
    free = known.let_go()
    finer = np.exp(log_peak(known.whole[free], free))
    peak[free, 0] = np.where(np.isnan(finer), peak[free, 0], finer)
    return Answers(windows, stiffness, peak)


def calibrated(model: Model, known: Grasps, told: Answers) -> Model:
    """The model with its probabilities and intervals as they proved on grasps not learnt from."""
    used = known.scored & np.isfinite(told.rigid)
    raw = told.rigid[used]
    classes = np.repeat(known.rigid, used.sum(axis=1)).astype(float)
    if np.unique(classes).size == 2:
        points = _isotonic(raw, classes)
        owner = np.repeat(np.arange(known.rigid.size), used.sum(axis=1))
        model = replace(model, calibration=points, sure=least_sure(raw, classes, owner))
    return replace(
        model,
        stiffness_band=_widened(_band(told.stiffness, known.stiffness), known.stiffness),
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


def _widened(band: Band, values: np.ndarray) -> Band:
    """The band, wider by half the mean distance of the values learnt: few tell nothing between."""
    levels = np.unique(np.log(values))
    between = 0.5 * float(np.ptp(levels)) / max(levels.size - 1, 1)
    return Band(band.x, band.low - between, band.high + between)


def _band(told: np.ndarray, true: np.ndarray) -> Band:
    """Where the truth lies about what is told, shape (n, 2), from 2.5 to 97.5 %."""
    found = np.isfinite(told).all(axis=1)
    estimate, at = told[found].T
    off = np.log(true[found] / estimate)
    bins = min(BINS, max(1, at.size // 40))
    order = np.argsort(at)
    parts = [part for part in np.array_split(order, bins) if part.size]
    ends = np.array([np.percentile(off[part], (2.5, 97.5)) for part in parts])
    return Band(np.array([at[part].mean() for part in parts]), *ends.T.copy())
