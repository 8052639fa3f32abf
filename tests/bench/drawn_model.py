"""A small model, trained in a moment on drawn closures: real forests, no simulation."""

import numpy as np

from hannes.bench.c_vectors import drawn
from hannes.recognition.features import NAMES
from hannes.recognition.forest import Forest, of_sklearn
from hannes.recognition.model import Band, Calibration, Model, held
from hannes.recognition.pressed import INPUTS, PressedStiffness
from hannes.recognition.windowing import Windowing


def forest(rows: np.ndarray, target: np.ndarray, trees: int) -> Forest:
    """Trees that each see half of the rows."""
    from sklearn.tree import DecisionTreeRegressor  # takes seconds, in every process that collects

    chance, grown = np.random.default_rng(1), []
    for k in range(trees):
        some = chance.permutation(len(rows))[: len(rows) // 2]
        tree = DecisionTreeRegressor(min_samples_leaf=5, max_features=0.5, random_state=k)
        grown.append(tree.fit(rows[some], target[some]))
    return of_sklearn(grown)


NUMBERS, HANDS = 160, 3  # of an empty closure, and points of it


def drawn_networks(error: float = 0.1, hands: int = HANDS) -> PressedStiffness:
    """Two small networks of drawn weights, whose log stiffness is about that of the border."""
    numbers = NUMBERS if hands else 0
    chance = np.random.default_rng(2)

    def weights(*shape: int) -> np.ndarray:
        return chance.normal(0.0, 0.5, shape).astype(np.float32)

    last = weights(2, 1, 6)
    last[..., -1] += 8.6
    return PressedStiffness(
        chance.normal(0.0, 1.0, INPUTS), 0.1 * weights(7, INPUTS), np.full(numbers, 0.3),
        0.1 * weights(hands, numbers), weights(2, 9, 8 + hands), weights(2, 5, 10),
        0.2 * last + np.float32(6.84) * (np.arange(6) == 5), np.full(1 + hands, 1e3),
        np.array([error, 0.5 * error]),
    ).check()  # fmt: skip


def drawn_model(sampling: float = 1000.0, window: float = 0.05, hop: float = 0.01) -> Model:
    """Model of 30 drawn closures: the steeper half of them counts as rigid."""
    windowing = Windowing(window, hop, sampling)
    grasps = [drawn(seed, round(1.1 * sampling), 1.0 / sampling) for seed in range(101, 131)]
    features = [windowing.features(each[np.newaxis])[0] for each in grasps]
    rows = np.concatenate([each[held(each)] for each in features])
    secant = rows[:, NAMES.index("peak_secant")]
    band = Band(np.array([0.0, 0.2, 0.7]), np.array([-0.1, -0.3, -0.5]), np.array([0.1, 0.2, 0.6]))
    return Model(
        windowing,
        5500.0,
        0.6,
        forest(rows, (secant > np.median(secant)).astype(float), 12),
        forest(rows, np.log(1e4 * np.maximum(secant, 1e-3)), 8),
        forest(rows, np.log(np.maximum(80.0 * rows[:, NAMES.index("peak_rise")], 0.1)), 9),
        None,
        Calibration(np.array([0.0, 0.2, 0.5, 0.9]), np.array([0.01, 0.15, 0.6, 0.99])),
        band,
        band,
        "drawn */ closures",
        drawn_networks(),
    )
