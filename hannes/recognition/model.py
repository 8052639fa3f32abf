"""The trained model, and its prediction for a recording: rigid or soft, stiffness, peak force."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.recognition.features import NAMES
from hannes.recognition.forest import Forest
from hannes.recognition.gaussian_process import ProcessMean
from hannes.recognition.hysteresis_features import grasp_features
from hannes.recognition.pressed import PressedStiffness
from hannes.recognition.windowing import Windowing

SINCE, RISE = NAMES.index("since"), NAMES.index("rise")
HELD = 0.06  # A above the free current, while an object is held
FADE = 0.03  # s, memory of the running decision
EXTREME = 4.0  # limit of the log odds of one window
LATER = 128  # windows, the newest, of which a grasp's stiffness is the median at most
NO_CONTACT = -2.0  # log odds of a window before the contact is detected: held, so soft
SOFT, RIGID, UNKNOWN = 0, 1, 2
WORDS = ("soft", "rigid", "don't know")


def held(features: np.ndarray) -> np.ndarray:
    """Windows in which an object is held, by the features (..., windows, n)."""
    return (np.nan_to_num(features[..., SINCE]) > 0.0) & (features[..., RISE] > HELD)


@dataclass(frozen=True)
class Calibration:
    """Calibration curve: a forest's probability x (rising) to its frequency y on unseen grasps."""

    x: np.ndarray
    y: np.ndarray

    def __call__(self, predicted: np.ndarray) -> np.ndarray:
        """Interpolate between the points, constant beyond them."""
        return np.interp(predicted, self.x, self.y)


@dataclass(frozen=True)
class Band:
    """95 % interval about an estimate: log offsets below and above it, along `x`.

    x rises: distance of a forest's outer quantiles, in the estimate's logarithm.
    """

    x: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __call__(self, estimate: float, x: float) -> tuple[float, float]:
        """Ends of the interval about an estimate (> 0), in its unit."""
        ends = np.interp(x, self.x, self.low), np.interp(x, self.x, self.high)
        return float(estimate * np.exp(ends[0])), float(estimate * np.exp(ends[1]))


@dataclass(frozen=True)
class Estimate:
    """A value with the ends of its 95 % interval, in SI."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Prediction:
    """A model's prediction: at the end of each window, and for the grasp as a whole.

    `time` [s] as in the recording; `rigid`: probability in each window; `running`: its fading mean,
    see `running`; `force`: the most so far [N], 0 in windows in which nothing is held; `touched`:
    which windows come after the contact, `held`: while the object is held; `probability`: of rigid,
    for the grasp; `sure`: the probability from which a class is named.
    """

    time: np.ndarray
    rigid: np.ndarray
    running: np.ndarray
    force: np.ndarray
    touched: np.ndarray
    held: np.ndarray
    probability: float
    sure: float
    stiffness: Estimate | None
    peak_force: Estimate | None

    @property
    def decision(self) -> str:
        """Of the grasp as a whole: soft, rigid or don't know; the last too without a contact."""
        if not self.held.any():
            return WORDS[UNKNOWN]
        return WORDS[int(decided(np.array([self.probability]), self.sure)[0])]


@dataclass(frozen=True)
class Model:
    """Forests for rigid (probability), stiffness (log N/m), most force so far (log N); calibration.

    Force and stiffness are medians over trees: shape and place of the object are unknown, and the
    few trees that saw a prism, with another force at the same current, do not shift a median. Once
    a grasp is released, `peak` predicts the peak force (log N) from its closing and opening. Before
    that, or where too few grasps trained it (None), the forest does. Intervals follow the spread of
    the trees. That of a grasp still held is as wide as after release, which nothing calibrates.
    `border`: stiffness [N/m] from which an object is rigid. `sure`: probability from which a class
    is named; below it the answer is "don't know". `pressed`: stiffness of an object that is pressed
    on in doubt, None where no such grasps trained it.
    """

    windowing: Windowing
    border: float
    sure: float
    rigid: Forest
    stiffness: Forest
    force: Forest
    peak: ProcessMean | None
    calibration: Calibration
    stiffness_band: Band
    force_band: Band
    trained: str = ""
    pressed: PressedStiffness | None = None

    def windows(self, rows: np.ndarray) -> np.ndarray:
        """Probability of rigid for rows of features (m, features), shape (m,)."""
        return self.calibration(self.rigid(rows))

    def predict(self, recording: Recording) -> Prediction:
        """Return the prediction for a recording of a grasp; BadInput where a channel is missing."""
        samples = self.windowing.samples(recording)
        rows = self.windowing.features(samples[np.newaxis])[0]
        time = recording.time[0] + self.windowing.times(samples.shape[0])
        touched, holds = rows[:, SINCE] > 0.0, held(rows)
        rigid = self.windows(rows)
        so_far = running(rigid, touched, self.windowing.hop)
        force = self.force.quantiles(rows)
        last = int(np.flatnonzero(holds)[-1]) if holds.any() else -1
        return Prediction(
            time, rigid, so_far, np.where(holds, np.exp(force[:, 1]), 0.0), touched, holds,
            float(so_far[last]) if holds.any() else 0.5, self.sure,
            self._stiffness(rows, holds), self._peak(samples, rows, force, holds),
        )  # fmt: skip

    def _stiffness(self, rows: np.ndarray, held: np.ndarray) -> Estimate | None:
        if not held.any():
            return None
        value, apart = grasp_stiffness(self.stiffness.quantiles(rows[held]))
        return Estimate(value, *self.stiffness_band(value, apart))

    def _peak(
        self, samples: np.ndarray, rows: np.ndarray, force: np.ndarray, held: np.ndarray
    ) -> Estimate | None:
        if not held.any():
            return None
        last = int(np.flatnonzero(held)[-1])
        value, apart = grasp_peak(force[last])
        whole = grasp_features(samples, rows, last, self.windowing)
        if self.peak and np.isfinite(whole).all():
            value = float(np.exp(self.peak(whole[np.newaxis])[0]))
        return Estimate(value, *self.force_band(value, apart))


def grasp_stiffness(quantiles: np.ndarray) -> tuple[float, float]:
    """One stiffness [N/m] and the spread of the trees, from quantiles of its logarithm, (n, 3).

    The quantiles are of the windows in which the object is held. Both results are medians over the
    later half of them, LATER windows at most.
    """
    return middle(quantiles[max(len(quantiles) // 2, len(quantiles) - LATER) :])


def middle(later: np.ndarray) -> tuple[float, float]:
    """The same of those windows alone, (n, 3)."""
    value, apart = np.median(later[:, 1]), np.median(later[:, 2] - later[:, 0])
    return float(np.exp(value)), float(apart)


def grasp_peak(quantiles: np.ndarray) -> tuple[float, float]:
    """One peak force [N] and the spread of the trees, from quantiles of log force, shape (3,).

    The quantiles are of the last window in which an object is held.
    """
    return float(np.exp(quantiles[1])), float(quantiles[2] - quantiles[0])


def running(rigid: np.ndarray, touched: np.ndarray, hop: float) -> np.ndarray:
    """Probability in windows `hop` [s] apart, by a fading mean of their log odds.

    The current shows an object once all fingers are in contact; the softer it is, the later. A
    window before the contact counts as NO_CONTACT.
    """
    odds = np.where(touched, np.clip(log_odds(rigid), -EXTREME, EXTREME), NO_CONTACT)
    share, mean = min(1.0, hop / FADE), np.zeros_like(odds)
    for k in range(odds.shape[-1]):
        before = mean[..., k - 1] if k else 0.0
        mean[..., k] = before + share * (odds[..., k] - before)
    return 1.0 / (1.0 + np.exp(-mean))


def faded(before: float, rigid: float, touched: bool, hop: float) -> float:
    """One step of that mean, in log odds."""
    odds = float(np.clip(log_odds(np.array([rigid]))[0], -EXTREME, EXTREME))
    return before + min(1.0, hop / FADE) * ((odds if touched else NO_CONTACT) - before)


def log_odds(probability: np.ndarray) -> np.ndarray:
    """log p / (1 - p), finite also at 0 and 1."""
    inside = np.clip(probability, 1e-6, 1.0 - 1e-6)
    return np.log(inside) - np.log1p(-inside)


def decided(probability: np.ndarray, sure: float) -> np.ndarray:
    """SOFT, RIGID or UNKNOWN for each probability of rigid; a class from `sure` on."""
    predicted = np.maximum(probability, 1.0 - probability) >= sure
    return np.where(predicted, np.where(probability >= 0.5, RIGID, SOFT), UNKNOWN)


def plain(estimate: Estimate | None, unit: str) -> dict[str, Any] | None:
    """As JSON has it."""
    return None if estimate is None else {**vars(estimate), "unit": unit}
