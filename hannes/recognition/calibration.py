"""Calibrates a model's probabilities and intervals on grasps that it was not trained on."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hannes.recognition.model import Band, Calibration, Model, grasp_peak, grasp_stiffness, held
from hannes.recognition.training_set import Grasps, decisive, last_held

BINS = 6  # of an interval's width
FOLDS = 5
Predictor = Callable[[np.ndarray, np.ndarray], np.ndarray]  # rows, grasp of each -> of each row
GRID, WIDTH = np.round(np.arange(0.5, 0.71, 0.01), 2), 0.02  # of confidence


@dataclass(frozen=True)
class HeldOutPredictions:
    """Predictions for n grasps by models that were not trained on them.

    rigid: of the forest, by window, shape (n, windows), NaN but where windows are scored or lead to
    the grasp's decision; stiffness [N/m] and peak force [N], each with the spread of the trees in
    its logarithm, shape (n, 2), NaN where nothing was held.
    """

    rigid: np.ndarray
    stiffness: np.ndarray
    peak: np.ndarray


def held_out_predictions(model: Model, known: Grasps) -> HeldOutPredictions:
    """Predictions of `model` for grasps that it was not trained on."""
    peak = model.peak
    return predictions_by(
        known,
        lambda rows, owner: model.rigid(rows),
        lambda rows, owner: model.stiffness.quantiles(rows),
        lambda rows, owner: model.force.quantiles(rows),
        lambda rows, owner: peak(rows) if peak else np.full(len(rows), np.nan),
    )


def predictions_by(
    known: Grasps,
    rigid: Predictor,
    log_stiffness: Predictor,
    log_force: Predictor,
    log_peak: Predictor,
) -> HeldOutPredictions:
    """Predictions for grasps, from predictors of rows of features.

    Each predictor takes rows (m, features) and the grasp of each row (m,). log_peak takes rows of
    whole grasps; where it gives NaN, or a grasp is still held, log_force is used.
    """
    there, some = known.scored | decisive(known.features), held(known.features)
    there &= ~np.isnan(known.features[..., 0])
    windows, logs = np.full(there.shape, np.nan), np.full((*some.shape, 3), np.nan)
    windows[there] = rigid(known.features[there], np.nonzero(there)[0])
    logs[some] = log_stiffness(known.features[some], np.nonzero(some)[0])
    stiffness, peak = (np.full((len(some), 2), np.nan) for _ in range(2))
    found, last = np.flatnonzero(some.any(axis=1)), last_held(known.features)
    stiffness[found] = [grasp_stiffness(logs[k][some[k]]) for k in found]
    peak[found] = [
        grasp_peak(each) for each in log_force(known.features[found, last[found]], found)
    ]
    free = known.released()
    finer = np.exp(log_peak(known.whole[free], free))
    peak[free, 0] = np.where(np.isnan(finer), peak[free, 0], finer)
    return HeldOutPredictions(windows, stiffness, peak)


def calibrated(model: Model, known: Grasps, predicted: HeldOutPredictions) -> Model:
    """The model, calibrated on predictions for grasps that it was not trained on."""
    used = known.scored & np.isfinite(predicted.rigid)
    raw = predicted.rigid[used]
    classes = np.repeat(known.rigid, used.sum(axis=1)).astype(float)
    if np.unique(classes).size == 2:
        points = _isotonic(raw, classes)
        owner = np.repeat(np.arange(known.rigid.size), used.sum(axis=1))
        model = replace(model, calibration=points, sure=least_sure(raw, classes, owner))
    return replace(
        model,
        stiffness_band=_widened(_band(predicted.stiffness, known.stiffness), known.stiffness),
        force_band=_band(predicted.peak, known.peak),
    )


def _isotonic(raw: np.ndarray, classes: np.ndarray) -> Calibration:
    from sklearn.isotonic import IsotonicRegression

    fitted = IsotonicRegression(y_min=0.005, y_max=0.995).fit(raw, classes)
    return Calibration(fitted.X_thresholds_.astype(float), fitted.y_thresholds_.astype(float))


def least_sure(raw: np.ndarray, classes: np.ndarray, owner: np.ndarray) -> float:
    """Probability from which a decision beats chance, by cross-validation over grasps.

    raw: the forest's probability by window, shape (m,); classes: 0 or 1; owner: the grasp of each
    window. It is the least value on a grid at which windows of about that confidence are right more
    often than half, at 95 % confidence.
    """
    predicted = np.full(raw.size, 0.5)
    for fold in range(FOLDS):
        out = owner % FOLDS == fold
        if np.unique(classes[~out]).size == 2 and out.any():
            predicted[out] = _isotonic(raw[~out], classes[~out])(raw[out])
    confidence, right = np.maximum(predicted, 1.0 - predicted), (predicted >= 0.5) == classes
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
    """The band, wider by half the mean distance of the training values: few leave wide gaps."""
    levels = np.unique(np.log(values))
    between = 0.5 * float(np.ptp(levels)) / max(levels.size - 1, 1)
    return Band(band.x, band.low - between, band.high + between)


def _band(predicted: np.ndarray, true: np.ndarray) -> Band:
    """Offsets of the truth from the predictions, shape (n, 2): 2.5 and 97.5 % quantiles."""
    found = np.isfinite(predicted).all(axis=1)
    estimate, at = predicted[found].T
    off = np.log(true[found] / estimate)
    bins = min(BINS, max(1, at.size // 40))
    order = np.argsort(at)
    parts = [part for part in np.array_split(order, bins) if part.size]
    ends = np.array([np.percentile(off[part], (2.5, 97.5)) for part in parts])
    return Band(np.array([at[part].mean() for part in parts]), *ends.T.copy())
