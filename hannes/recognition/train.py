"""`hannes train`: train a model on a data set's grasps, and score it on unseen ones."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.dataset.read import DataSet
from hannes.recognition.bagging import SHARE, Bagged, Rows, bagged
from hannes.recognition.calibration import (
    HeldOutPredictions,
    calibrated,
    held_out_predictions,
    predictions_by,
)
from hannes.recognition.feature_levels import rounded
from hannes.recognition.forest import single
from hannes.recognition.gaussian_process import FEWEST as FEWEST_LET_GO
from hannes.recognition.gaussian_process import ProcessMean, train_process
from hannes.recognition.model import SINCE, Band, Calibration, Model, decided, held, running
from hannes.recognition.train_pressed import train_pressed
from hannes.recognition.training_set import (
    Grasps,
    TrainingSet,
    grasps,
    last_held,
    training_set,
)
from hannes.recognition.windowing import Windowing

LEAST = 0.5  # N, lower limit of the force target
EARLIER = 0.03  # share of the windows before a grasp's last that train the force
LAST = 30.0  # weight of that last window: many times all earlier ones
FEWEST = 30  # grasps of a learning curve
TREES = 320  # of the class: of 80 alone, F1 per window differs by a point from seed to seed
FEWEST_TREES = 10
FEW = 5000  # windows: with fewer, each tree trains on all windows of its grasps
LEAF = 8  # least windows of a leaf, of class and stiffness, where there are more
MOST_WINDOWS = 30_000  # that a tree learns from: neighbours say nearly the same


def train(
    path: str | Path,
    *,
    trees: int = TREES,
    seed: int = 0,
    windowing: Windowing | None = None,
    jobs: int | None = -1,
    most: int | None = None,
    leaf: int = 0,
) -> tuple[Model, dict[str, Any]]:
    """Train on a data set; return the model, and the scores of its parts on unseen grasps.

    Unseen grasps calibrate it too: probabilities and intervals come from predictions of trees and
    processes that were not trained on them. `trees` classify, an eighth of that number predict
    stiffness, three quarters force. `jobs` as joblib's. At most `most` grasps train where that is
    given. `leaf`: fewest windows in a leaf of any tree, for small tables on a board; values of
    leaves have single precision then. Grasps of the role "test" are only scored, those of the role
    "pressed" train the stiffness of pressed objects alone. Raises BadInput
    where the file is no data set, or has too few grasps of a class.
    """
    if seed < 0:
        raise BadInput(f"seed = {seed}: expected 0 or more")
    given = training_set(path, windowing or Windowing())
    data, windowing, known = given.data, given.windowing, given.grasps
    of = _origin(data, seed)
    if most is not None:
        known = known.some(np.random.default_rng(seed).permutation(known.rigid.size)[:most])
        of += f"; {known.rigid.size} grasps of it"
    model, unseen = _trained(known, given, of, trees, seed, jobs, leaf)
    model = replace(model, pressed=train_pressed(data, windowing, seed))
    predicted = {"title": data.title, "grasps": int(known.rigid.size)}
    predicted["unseen_scores"] = worth(model, known, unseen)
    if model.pressed:
        unknown, hand_known = (100.0 * float(each) for each in model.pressed.error)
        predicted["pressed_error_percent"] = unknown
        if model.pressed.hand_centre.size:
            predicted["pressed_error_percent_hand_known"] = hand_known
    if data.role("test").any():
        test = grasps(data, data.role("test"), windowing)
        predicted["test_scores"] = worth(model, test, held_out_predictions(model, test))
    return model, predicted


def _origin(data: DataSet, seed: int) -> str:
    """What a model says that it was trained on."""
    return f"{data.title}; fingerprint {data.digest}; seed {seed}"


def curve(
    path: str | Path,
    *,
    trees: int = TREES // 2,
    seed: int = 0,
    windowing: Windowing | None = None,
    jobs: int | None = -1,
) -> Iterator[tuple[int, Model]]:
    """Learning curve of a data set, as `curve_of` has it."""
    return curve_of(training_set(path, windowing or Windowing()), trees=trees, seed=seed, jobs=jobs)


def curve_of(
    given: TrainingSet,
    *,
    trees: int = TREES // 2,
    seed: int = 0,
    jobs: int | None = -1,
    whole: Model | None = None,
) -> Iterator[tuple[int, Model]]:
    """Learning curve: models trained on more and more grasps, each with their number.

    The numbers are all that `train` uses, a quarter, a quarter of that, and so on to some 30. A
    part with too few of a class is skipped. `whole` is the last one where it was trained on all
    of these grasps and has no fewer trees: it is not trained again.
    """
    known, of = given.grasps, _origin(given.data, seed)
    order = np.random.default_rng(seed).permutation(known.rigid.size)
    steps = 1 + max(0, int(np.log(order.size / FEWEST) / np.log(4.0)))
    for count in [round(order.size / 4.0**k) for k in range(steps)][::-1]:
        part = known.some(order[:count])
        if count == order.size and whole is not None and _is_of(whole, given, trees):
            yield count, whole
        elif count == order.size or _enough(part):
            yield count, _trained(part, given, of, trees, seed, jobs)[0]


def _is_of(model: Model, given: TrainingSet, trees: int) -> bool:
    """Whether a model was trained on all of these grasps, and has that many trees or more."""
    seed = model.trained.rpartition(" ")[2]
    same = seed.isdecimal() and model.trained == _origin(given.data, int(seed))
    enough = model.rigid.starts.size - 1 >= trees
    return same and enough and model.windowing == given.windowing


def _enough(known: Grasps) -> bool:
    """Whether two grasps or more of each class are held."""
    some = held(known.features).any(axis=1)
    return int(np.bincount(known.rigid[some].astype(int), minlength=2).min()) >= 2


@dataclass(frozen=True)
class _Forests:
    """Of the class (share of rigid), stiffness (log N/m) and the most force so far (log N)."""

    rigid: Bagged
    stiffness: Bagged
    force: Bagged


def _trained(
    known: Grasps,
    given: TrainingSet,
    of: str,
    trees: int,
    seed: int,
    jobs: int | None,
    leaf: int = 0,
) -> tuple[Model, HeldOutPredictions]:
    """A calibrated model `of` some grasps; predictions by trees that have not seen them."""
    if not _enough(known):
        raise BadInput(
            f"{given.data.path}: expected two grasps or more of soft and of rigid objects"
        )
    made, (peak, of_peak) = _grown(known, trees, seed, jobs, leaf), _peak(known, seed)
    forests = [each.forest() for each in (made.rigid, made.stiffness, made.force)]
    rigid, stiffness, force = map(single, forests) if leaf else forests
    none = np.zeros(1)
    model = Model(
        given.windowing,
        given.data.border,
        0.5,
        rigid,
        stiffness,
        force,
        peak,
        Calibration(np.array([0.0, 1.0]), np.array([0.0, 1.0])),
        Band(none, none, none),
        Band(none, none, none),
        trained=of,
    )
    unseen = predictions_by(
        known,
        made.rigid.mean_unseen,
        made.stiffness.quantiles_unseen,
        made.force.quantiles_unseen,
        lambda rows, owner: of_peak[owner],
    )
    return calibrated(model, known, unseen), unseen


def _peak(known: Grasps, seed: int) -> tuple[ProcessMean | None, np.ndarray]:
    """Predictor of the peak force (log N), and held-out predictions of it, shape (n,)."""
    free, unseen = known.released(), np.full(known.peak.size, np.nan)
    if free.size < FEWEST_LET_GO:
        return None, unseen
    peak, unseen[free] = train_process(known.whole[free], np.log(known.peak[free]), seed)
    return peak, unseen


def _grown(known: Grasps, trees: int, seed: int, jobs: int | None, fewest: int) -> _Forests:
    from hannes.recognition.estimators import BaggedTrees

    used = known.scored | held(known.features)
    few = used.sum() < FEW
    features = known.features if few else rounded(known.features, used)
    leaf, share = max(2 if few else LEAF, fewest), 1.0 if few else 0.5
    bag = BaggedTrees(trees, leaf, _thinned(share, used), seed, jobs)
    bag.fit(features, known.rigid.astype(int), used)
    so_far = np.maximum.accumulate(known.force, axis=1)
    stiffness = np.broadcast_to(known.stiffness[:, np.newaxis], used.shape)

    def regression(
        trees: int, value: np.ndarray, weight: np.ndarray, share: float, **how: Any
    ) -> Bagged:
        which = weight > 0.0
        owner, target = np.nonzero(which)[0], np.log(np.maximum(value[which], LEAST))
        rows = Rows(features[which], target, weight[which], owner)
        share = _thinned(share, which)
        return bagged(rows, len(used), max(trees, FEWEST_TREES), share, seed, jobs, **how)

    weight = _weight_of_force(known, used & (so_far > LEAST), seed)
    how = {"min_samples_leaf": leaf, "max_features": 0.4}
    return _Forests(
        bag.bagged_,
        regression(trees // 8, stiffness, used.astype(float), share / 2.0, **how),
        regression(3 * trees // 4, so_far, weight, 1.0, min_samples_leaf=max(2, fewest),
                   max_features=0.3),
    )  # fmt: skip


def _thinned(share: float, used: np.ndarray) -> float:
    """Share of its grasps' windows that a tree learns from: at most MOST_WINDOWS of them."""
    return min(share, MOST_WINDOWS / (SHARE * max(1, int(used.sum()))))


def _weight_of_force(known: Grasps, pressed: np.ndarray, seed: int) -> np.ndarray:
    """Weights of the windows that train the force, 0 elsewhere; shape (grasps, windows).

    The release says more about the peak than the moment of the peak does, hence the weight of the
    last window. The spread of its trees gives the width of the peak's interval, and where grasps
    are few, they predict the peak itself. Earlier windows serve a grasp that is still held where
    its recording ends.
    """
    drawn = np.random.default_rng(seed).random(pressed.shape) < EARLIER
    weight = (pressed & drawn).astype(float)
    last = last_held(known.features)
    found = np.flatnonzero(last >= 0)
    weight[found, last[found]] = LAST
    return weight


def worth(model: Model, known: Grasps, predicted: HeldOutPredictions) -> dict[str, float]:
    """Shares of right decisions, and errors, on grasps that did not train the model."""
    there = np.isfinite(predicted.rigid)  # no prediction for a grasp that every tree has seen
    scored = known.scored & there
    rigid = np.full(there.shape, 0.5)
    rigid[there] = model.calibration(predicted.rigid[there])
    windows = decided(rigid, model.sure) == known.rigid[:, np.newaxis]
    last = last_held(known.features)
    touched = np.nan_to_num(known.features[..., SINCE]) > 0.0
    whole = running(rigid, touched, model.windowing.hop)[np.arange(last.size), last]
    grasp = decided(whole, model.sure) == known.rigid
    stiff = np.log(predicted.stiffness[:, 0] / known.stiffness)
    miss = np.abs(predicted.peak[:, 0] / known.peak - 1.0)
    return {
        "grasps": int(known.rigid.size),
        "windows_right": float(windows[scored].mean()),
        "grasps_right": float(grasp[(last >= 0) & there.any(axis=1)].mean()),
        "brier": float(np.mean((rigid - known.rigid[:, np.newaxis])[scored] ** 2)),
        "stiffness_factor": float(np.exp(np.nanmedian(np.abs(stiff)))),
        "peak_force_error_percent": float(100.0 * np.nanmedian(miss)),
    }
