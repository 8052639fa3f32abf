"""`hannes train`: learn from a data set's grasps; some of them are kept to say what it is worth."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hannes.dataset.read import DataSet, read
from hannes.errors import BadInput
from hannes.recognition.calibrated import Answers, answers, calibrated, estimates, joined
from hannes.recognition.cut import Cut
from hannes.recognition.forest import Forest, of_sklearn
from hannes.recognition.grasps import Grasps, grasps, held, last_held
from hannes.recognition.model import SINCE, Band, Calibration, Model, decided, running

TURNS = 8  # trainings by which a design by hand is judged
KEPT = 0.2  # share of the grasps that is not learnt from
LEAST = 0.5  # N, of the force that is learnt
EARLIER = 0.1  # share that force is learnt from of the windows before a grasp's last
LAST = 30.0  # weight of that last, from which the peak is told: ten times all earlier ones
FEWEST = 30  # grasps of a learning curve


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

    A fifth of the grasps for training is kept for calibration and intervals; below 50 none is, and
    each is judged by a model that learnt from others. `most` grasps are learnt from where that is
    given. Grasps of the role "test" are only reported on. Raises BadInput where the file is no data
    set, or has too few grasps of a class.
    """
    data, cut = read(path), cut or Cut()
    known = grasps(data, data.role("train"), cut)
    kept = _kept(known, seed)
    learnt = np.flatnonzero(~kept)
    if most is not None:
        learnt = np.random.default_rng(seed).permutation(learnt)[:most]
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
    order = np.random.default_rng(seed).permutation(np.flatnonzero(~kept))
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
    part = known.some(learnt)
    model = _fitted(part, cut, data, trees, seed, jobs)
    if kept.any():
        judged = known.some(kept)
        return calibrated(model, judged, answers(model, judged))
    return calibrated(model, part, _in_turn(part, cut, data, trees, seed, jobs))


def _in_turn(
    known: Grasps, cut: Cut, data: DataSet, trees: int, seed: int, jobs: int | None
) -> Answers:
    """What is told of each grasp by a model that learnt from others, where there are few."""
    from sklearn.model_selection import StratifiedKFold

    turns = min(TURNS, int(np.bincount(known.rigid.astype(int), minlength=2).min()))
    if turns < 2:
        raise BadInput(f"{data.path}: expected two grasps or more of soft and of rigid objects")
    folds = StratifiedKFold(turns, shuffle=True, random_state=seed)
    parts, places = [], []
    for others, place in folds.split(known.rigid, known.rigid):
        model = _fitted(known.some(others), cut, data, trees, seed, jobs)
        parts.append(answers(model, known.some(place)))
        places.append(place)
    return joined(parts, places)


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

    def regression(
        which: np.ndarray, target: np.ndarray, leaf: int, share: float, weight: np.ndarray
    ) -> Forest:
        how = {"min_samples_leaf": leaf, "max_features": 0.4, "max_samples": share}
        made = RandomForestRegressor(max(trees // 2, 10), random_state=seed, n_jobs=jobs, **how)
        return of_sklearn(made.fit(known.features[which], target[which], weight[which]))

    stiffness = np.broadcast_to(np.log(known.stiffness)[:, np.newaxis], used.shape)
    so_far = np.maximum.accumulate(known.force, axis=1)
    weight = _weight_of_force(known, used & (so_far > LEAST), seed)
    nothing = np.zeros(1)
    return Model(
        cut,
        data.border,
        0.5,
        rigid,
        regression(used, stiffness, leaf, share / 2, np.ones(used.shape)),
        regression(weight > 0.0, np.log(np.maximum(so_far, LEAST)), 1, 1.0, weight),
        Calibration(np.array([0.0, 1.0]), np.array([0.0, 1.0])),
        Band(nothing, nothing, nothing),
        Band(nothing, nothing, nothing),
        trained=f"{data.title}; fingerprint {data.digest}; seed {seed}",
    )


def _weight_of_force(known: Grasps, pressed: np.ndarray, seed: int) -> np.ndarray:
    """Weights of windows where force is learnt, 0 where it is not; shape (grasps, windows).

    How a hand lets go tells more of the peak than the moment of the peak does, hence the weight of
    the last window; the earlier ones are for a grasp that is still held where its recording ends.
    """
    drawn = np.random.default_rng(seed).random(pressed.shape) < EARLIER
    weight = (pressed & drawn).astype(float)
    last = last_held(known.features)
    found = np.flatnonzero(last >= 0)
    weight[found, last[found]] = LAST
    return weight


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
