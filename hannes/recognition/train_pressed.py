"""Training of the stiffness by traces, on grasps that press on in doubt.

The networks learn the other values of hand and object too, which a simulated grasp knows: what they
find of these helps to distinguish a soft object from a weak hand. Only the stiffness is kept.
"""

from typing import Any

import numpy as np

from hannes.core.io.progress import progress_bar
from hannes.dataset.read import DataSet
from hannes.recognition.features import CHANNELS
from hannes.recognition.model import SINCE
from hannes.recognition.pressed import (
    GROUP,
    INPUTS,
    START,
    TRACE,
    PressedStiffness,
    bin_size,
    due,
    trace_inputs,
)
from hannes.recognition.training_set import WEAKEST
from hannes.recognition.windowing import Windowing

FEWEST = 500  # grasps
POINTS, POWER = 70, 0.25  # principal components; share of their variance that stays
NETS, UNITS = 4, (128, 64)
ROUNDS, BATCH, RATE, PENALTY = 80, 64, 3e-3, 1e-3
BESIDE = 0.02  # weight of the square of each other value of a grasp, beside that of the stiffness
APART = 8  # one in so many grasps is unseen by a network
MIDDLE, SIZE = 8.6, 0.7  # of the log stiffness: targets are less the one, over the other
NEAR = 1.5  # factor about the border within which the error is taken
KNOWN = "object.stiffness"
STATED = ("noise.", "resolution.", "gravity.")  # of the sensors and of the place
CURRENT, ANGLE, OTHER = 2.2e-3, 1e-4, 1e-3  # A, rad, rad or s: what noise leaves of a mean


def train_pressed(data: DataSet, windowing: Windowing, seed: int) -> PressedStiffness | None:
    """Train on the grasps of the role "pressed"; None where there are too few of them."""
    rows, target, others = inputs_of(data, windowing)
    if target.size < FEWEST:
        return None
    return fitted(rows, target, float(np.log(data.border)), seed, others)


def inputs_of(data: DataSet, windowing: Windowing) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (n, INPUTS), log stiffness (n,), other values (n, k) of grasps with a touch in time.

    The other values are what else of hand and object varies, each less its mean, of size 1.
    """
    size = bin_size(windowing.sampling)
    if "pressed" not in data.roles or not size:
        return np.zeros((0, INPUTS)), np.zeros(0), np.zeros((0, 0))
    held = data.usable & (data.table["peak_force"] > WEAKEST)
    which = np.flatnonzero(held & data.role("pressed"))
    rows: list[np.ndarray] = []
    used: list[int] = []
    for block in data.blocks(which, CHANNELS):
        for samples, touch in zip(block.astype(float), _touches(block, windowing), strict=True):
            needed = due(touch, size)
            if needed is not None and needed <= len(samples):
                rows.append(trace_inputs(samples.T, touch, windowing.sampling))
            used.append(len(rows))
    taken = which[np.diff(used, prepend=0) > 0]
    known = np.log(data.table[KNOWN][taken])
    return np.array(rows).reshape(-1, INPUTS), known, _others(data, taken)


def other_names(data: DataSet) -> list[str]:
    """Names of what else of hand and object varies between the grasps of the role "pressed"."""
    names = [name for name in data.table.dtype.names or () if "." in name]
    names = [name for name in names if name != KNOWN and not name.startswith(STATED)]
    pressed = data.role("pressed")
    if not pressed.any():
        return []
    return [name for name in names if _spread(data.table[name][pressed].astype(float)) > 0.0]


def _spread(values: np.ndarray) -> float:
    """Standard deviation; 0 where rounding alone makes one, or the values are damaged."""
    with np.errstate(all="ignore"):
        spread, most = float(values.std()), float(np.abs(values).max(initial=0.0))
    return spread if np.isfinite(spread) and spread > 1e-9 * most else 0.0


def _others(data: DataSet, which: np.ndarray) -> np.ndarray:
    """What else of hand and object varies in grasps `which` (n,), of size 1; shape (n, k)."""
    names = other_names(data)
    if not names or not which.size:
        return np.zeros((which.size, 0))
    values = np.stack([data.table[name][which].astype(float) for name in names], axis=1)
    spread = values.std(axis=0)
    return (values - values.mean(axis=0)) / np.where(spread > 0.0, spread, 1.0)


def _touches(block: np.ndarray, windowing: Windowing) -> list[int]:
    """Samples of the touches in grasps (m, samples, channels); 0 where there is none."""
    since = np.nan_to_num(windowing.features(block)[..., SINCE])[:, -1]
    last = windowing.ends(block.shape[1])[-1] - 1
    found = last - np.round(since * windowing.sampling).astype(int)
    return [int(each) for each in np.where(since > 0.0, found, 0)]


def fitted(
    rows: np.ndarray, target: np.ndarray, border: float, seed: int, others: np.ndarray | None = None
) -> PressedStiffness:
    """Networks for inputs (n, INPUTS) and log stiffness (n,); `border`: that of the classes.

    others: what the networks learn beside it (n, k), of size 1.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # sums of many threads end on other bits
        centre, mix = _mixed(rows)
        points = ((rows - centre) @ mix.T).astype(np.float32)
        beside = np.zeros((target.size, 0)) if others is None else np.sqrt(BESIDE) * others
        wanted = np.column_stack([(target - MIDDLE) / SIZE, beside]).astype(np.float32)
        fold = np.arange(target.size) % APART
        made, unseen = [], np.full(target.size, np.nan)
        for net in progress_bar(range(NETS), "training networks", NETS, delay=2.0, leave=False):
            apart = fold == net
            trained = _network(points[~apart], wanted[~apart], seed + net)
            found = trained.predict(points[apart]).reshape(apart.sum(), -1)[:, 0]
            unseen[apart] = found * SIZE + MIDDLE
            made.append(_arrays(trained))
    first, second, last = (np.stack(each) for each in zip(*made, strict=True))
    near = np.isfinite(unseen) & (np.abs(target - border) < np.log(NEAR))
    error = float(np.sqrt(np.mean(np.square(unseen - target)[near]))) if near.any() else 1.0
    return PressedStiffness(
        centre, mix, first, second, last,
        np.array([float(np.abs(points).max())]), np.array([max(error, 1e-3)]),
    ).check()  # fmt: skip


def _mixed(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre of the inputs, and the principal components of what exceeds their noise.

    Components differ in size by thousands, and the small ones show the hand: only a share of the
    difference stays.
    """
    noise = np.concatenate(
        [np.full(n, x) for n, x in (
            (TRACE, CURRENT), (2 * TRACE, ANGLE), (START, CURRENT), (START, ANGLE), (2, OTHER),
        )]
    )  # fmt: skip
    noise = noise / np.sqrt(GROUP / 4.0)
    centre = rows.mean(axis=0)
    size, axes = np.linalg.eigh(np.cov(((rows - centre) / noise).T))
    size, axes = size[::-1][:POINTS], axes[:, ::-1][:, :POINTS]
    mix = (axes / np.sqrt(size) * (size / size[0]) ** POWER / noise[:, np.newaxis]).T
    scale = np.sqrt(np.square((rows - centre) @ mix.T).sum(axis=1).mean() / 12.0)
    return centre, (mix / scale).astype(np.float32)


def _network(points: np.ndarray, wanted: np.ndarray, seed: int) -> Any:
    """A network after ROUNDS over all points, by steps that shrink as a cosine."""
    from sklearn.neural_network import MLPRegressor

    net = MLPRegressor(
        hidden_layer_sizes=UNITS, alpha=PENALTY, batch_size=BATCH, learning_rate_init=RATE,
        random_state=seed,
    )  # fmt: skip
    wanted = wanted[:, 0] if wanted.shape[1] == 1 else wanted
    for k in range(ROUNDS):
        net.partial_fit(points, wanted)
        net._optimizer.learning_rate_init = RATE * 0.5 * (1.0 + np.cos(np.pi * (k + 1) / ROUNDS))
    return net


def _arrays(net: Any) -> list[np.ndarray]:
    """Weights of a network's layers with their constants; of the last the log stiffness alone."""
    layers = [
        np.concatenate([w.T, b[:, np.newaxis]], axis=1).astype(float)
        for w, b in zip(net.coefs_, net.intercepts_, strict=True)
    ]
    layers[-1] = SIZE * layers[-1][:1]
    layers[-1][:, -1] += MIDDLE
    return [each.astype(np.float32) for each in layers]
