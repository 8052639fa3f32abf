"""Training of the stiffness by traces, on grasps that press on in doubt.

The networks learn the other values of hand and object too, which a simulated grasp knows: what they
find of these helps to distinguish a soft object from a weak hand. Only the stiffness is kept.

Where the data set has empty closures of its hands, each grasp trains with what its hand showed, and
half of them without, so that a hand that is not known has an estimate too.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.io.progress import progress_bar
from hannes.dataset.empty_closure import mean_size
from hannes.dataset.read import DataSet
from hannes.recognition.features import CHANNELS
from hannes.recognition.model import SINCE
from hannes.recognition.pressed import (
    GROUP,
    INPUTS,
    KNOWN,
    START,
    TRACE,
    UNKNOWN,
    PressedStiffness,
    bin_size,
    due,
    trace_inputs,
)
from hannes.recognition.training_set import WEAKEST
from hannes.recognition.windowing import Windowing

FEWEST = 500  # grasps
POINTS, POWER = 70, 0.25  # principal components; share of their variance that stays
FEWEST_HANDS, LEAST = 200, 1e-3  # hands; variance of a point, that of the noise being some 1
HAND_POINTS, HIDDEN = 25, 0.5  # points of empty closures; share of grasps without them, besides
MARGIN = 1.5  # by which a hand may be beyond the farthest, at each of these points
NETS, UNITS = 4, (128, 64)
ROUNDS, BATCH, RATE, PENALTY = 80, 64, 3e-3, 1e-3
BESIDE = 0.02  # weight of the square of each other value of a grasp, beside that of the stiffness
APART = 8  # one in so many grasps is unseen by a network
MIDDLE, SIZE = 8.6, 0.7  # of the log stiffness: targets are less the one, over the other
NEAR = 1.5  # factor about the border within which the error is taken
STIFFNESS = "object.stiffness"
STATED = ("noise.", "resolution.", "gravity.")  # of the sensors and of the place
CURRENT, ANGLE, OTHER = 2.2e-3, 1e-4, 1e-3  # A, rad, rad or s: what noise leaves of a mean


def train_pressed(data: DataSet, windowing: Windowing, seed: int) -> PressedStiffness | None:
    """Train on the grasps of the role "pressed"; None where there are too few of them."""
    known = inputs_of(data, windowing)
    return None if known.target.size < FEWEST else fitted(known, float(np.log(data.border)), seed)


@dataclass(frozen=True)
class Known:
    """Inputs (n, INPUTS), log stiffness (n,), other values (n, k), empty closures (n, numbers).

    The other values are what else of hand and object varies, each less its mean, of size 1. The
    numbers of a hand that did not close on nothing are NaN.
    """

    rows: np.ndarray
    target: np.ndarray
    others: np.ndarray
    hands: np.ndarray

    @property
    def shown(self) -> np.ndarray:
        """Whether the grasp's hand closed on nothing, shape (n,)."""
        return np.isfinite(self.hands).all(axis=1)

    def some(self, which: Any) -> "Known":
        """Only the grasps `which`."""
        return Known(*(each[which] for each in vars(self).values()))


def inputs_of(data: DataSet, windowing: Windowing) -> Known:
    """What is known of the grasps of the role "pressed" with a touch in time."""
    size = bin_size(windowing.sampling)
    if "pressed" not in data.roles or not size:
        none = np.zeros((0, 0))
        return Known(np.zeros((0, INPUTS)), np.zeros(0), none, none)
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
    known = np.log(data.table[STIFFNESS][taken])
    hands = data.empty(taken) if mean_size(windowing.sampling) else np.zeros((taken.size, 0))
    return Known(np.array(rows).reshape(-1, INPUTS), known, _others(data, taken), hands)


def other_names(data: DataSet) -> list[str]:
    """Names of what else of hand and object varies between the grasps of the role "pressed"."""
    names = [name for name in data.table.dtype.names or () if "." in name]
    names = [name for name in names if name != STIFFNESS and not name.startswith(STATED)]
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


def fitted(known: Known, border: float, seed: int) -> PressedStiffness:
    """Networks of grasps; `border`: log stiffness of that of the classes."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # sums of many threads end on other bits
        centre, mix = _mixed(known.rows)
        hand_centre, hand_mix = _hands_mixed(known.hands)
        points = ((known.rows - centre) @ mix.T).astype(np.float32)
        hands = (known.hands[:, : hand_centre.size] - hand_centre) @ hand_mix.T
        hands = np.nan_to_num(hands).astype(np.float32)
        made, unseen = _networks(points, hands, known, seed)
    first, second, last = (np.stack(each) for each in zip(*made, strict=True))
    farthest = np.abs(points).max(initial=1e-3), *MARGIN * np.abs(hands).max(axis=0, initial=1e-6)
    unseen[KNOWN, ~known.shown] = np.nan  # their hands are not known
    errors = [_error(each, known.target, border) for each in unseen]
    said = np.array(farthest), np.array(errors)
    return PressedStiffness(centre, mix, hand_centre, hand_mix, first, second, last, *said).check()


def _networks(
    points: np.ndarray, hands: np.ndarray, known: Known, seed: int
) -> tuple[list[list[np.ndarray]], np.ndarray]:
    """Arrays of the networks, and what they say of unseen grasps without and with the hand (2, n).

    Each has not seen one in APART of the grasps; what none has left out is NaN.
    """
    wanted = np.column_stack([(known.target - MIDDLE) / SIZE, np.sqrt(BESIDE) * known.others])
    wanted, fold = wanted.astype(np.float32), np.arange(known.target.size) % APART
    ways = [np.hstack([points, each]) for each in (np.zeros_like(hands), hands)]
    made, unseen = [], np.full((2, known.target.size), np.nan)
    for net in progress_bar(range(NETS), "training networks", NETS, delay=2.0, leave=False):
        some = np.flatnonzero(fold != net)
        hidden = np.random.default_rng([seed, net]).random(some.size) < HIDDEN
        fewer = some[hidden & (hands.shape[1] > 0)]
        rows = np.concatenate([ways[KNOWN][some], ways[UNKNOWN][fewer]])
        trained = _network(rows, wanted[np.concatenate([some, fewer])], seed + net)
        for way, left in zip(ways, unseen, strict=True):
            found = trained.predict(way[fold == net]).reshape((fold == net).sum(), -1)[:, 0]
            left[fold == net] = found * SIZE + MIDDLE
        made.append(_arrays(trained))
    return made, unseen


def _error(unseen: np.ndarray, target: np.ndarray, border: float) -> float:
    """Standard deviation of the log stiffness near the border; 1 where none is there."""
    near = np.isfinite(unseen) & (np.abs(target - border) < np.log(NEAR))
    if not near.any():
        return 1.0
    return max(float(np.sqrt(np.mean(np.square(unseen - target)[near]))), 1e-3)


def _hands_mixed(hands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre of the numbers of empty closures, and their principal components, the largest of 1."""
    whole = hands[np.isfinite(hands).all(axis=1)]
    if not hands.shape[1] or len(whole) < FEWEST_HANDS:
        return np.zeros(0), np.zeros((0, 0), np.float32)
    noise = np.repeat([CURRENT, ANGLE], hands.shape[1] // 2)
    centre = whole.mean(axis=0)
    size, axes = _components((whole - centre) / noise, HAND_POINTS)
    size = np.maximum(size, LEAST)  # a data set whose hands are alike
    mix = axes / np.sqrt(size) * (size / size[0]) ** POWER / noise[:, np.newaxis]
    return centre, mix.T.astype(np.float32)


def _components(values: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Variances of the first principal components, and these (columns), the largest first."""
    size, axes = np.linalg.eigh(np.cov(values.T))
    return size[::-1][:most], axes[:, ::-1][:, :most]


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
    size, axes = _components((rows - centre) / noise, POINTS)
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
