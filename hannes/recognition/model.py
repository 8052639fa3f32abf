"""What was learnt from simulated grasps, of a recording: rigid or soft, how stiff, how hard."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.recording.recording import Recording
from hannes.recognition.features import NAMES
from hannes.recognition.forest import Forest
from hannes.recognition.gaussian_process import ProcessMean
from hannes.recognition.hysteresis_features import of_grasp
from hannes.recognition.windowing import Cut

SINCE, RISE = NAMES.index("since"), NAMES.index("rise")
HELD = 0.06  # A above the free current, while an object is held
FADE = 0.03  # s, memory of the running decision
EXTREME = 4.0  # log odds of one window count for no more
UNFELT = -2.0  # log odds of a window in which the motor has not felt a touch: held, so soft
SOFT, RIGID, UNKNOWN = 0, 1, 2
WORDS = ("soft", "rigid", "don't know")


def held(features: np.ndarray) -> np.ndarray:
    """Windows in which an object is held, as far as the features (..., windows, n) tell."""
    return (np.nan_to_num(features[..., SINCE]) > 0.0) & (features[..., RISE] > HELD)


@dataclass(frozen=True)
class Calibration:
    """What a forest says against what it was worth on grasps it had not seen: x rising, y."""

    x: np.ndarray
    y: np.ndarray

    def __call__(self, told: np.ndarray) -> np.ndarray:
        """Interpolate between the points; beyond them stay at the last."""
        return np.interp(told, self.x, self.y)


@dataclass(frozen=True)
class Band:
    """95 % interval about an estimate: log offsets below and above it, along `x`.

    x rises: how far a forest's outer quantiles lie apart, in the estimate's logarithm.
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
class Told:
    """What a recording tells: at the end of each window, and of the grasp as a whole.

    `time` [s] as in the recording; `rigid`: probability in each window; `running`: the same for
    what was just seen, see `running`; `force`: the most so far [N], 0 in windows in which nothing
    is held; `touched`: which windows come after a touch, `held`: while the object is held; `sure`:
    the probability from which a class is told.
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
        """Of the grasp as a whole: soft, rigid or don't know; that too where nothing was felt."""
        if not self.held.any():
            return WORDS[UNKNOWN]
        return WORDS[int(decided(np.array([self.probability]), self.sure)[0])]


@dataclass(frozen=True)
class Model:
    """Forests for rigid (probability), stiffness (log N/m), most force so far (log N); their worth.

    Force is the median over its trees: shape and place of what is held are unknown, and the few
    trees that saw a prism, which gives another force at the same current, do not pull a median.
    So is stiffness. The peak force (log N) is told by `peak` once a grasp is let go, from how it
    was closed and opened; where there are too few grasps to learn that from (None), or the grasp is
    still held, by the forest. Intervals go by how far the trees lie apart; that of a grasp still
    held is as wide as if it had been let go, which nothing calibrates.
    `sure`: probability from which a class is told; below it the answer is "don't know".
    """

    cut: Cut
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

    def windows(self, rows: np.ndarray) -> np.ndarray:
        """Probability of rigid for rows of features (m, features), shape (m,)."""
        return self.calibration(self.rigid(rows))

    def tell(self, recording: Recording) -> Told:
        """Say what a recording of a grasp tells; BadInput where a channel is missing."""
        samples = self.cut.samples(recording)
        rows = self.cut.features(samples[np.newaxis])[0]
        time = recording.time[0] + self.cut.times(samples.shape[0])
        touched, holds = rows[:, SINCE] > 0.0, held(rows)
        rigid = self.windows(rows)
        so_far = running(rigid, touched, self.cut.hop)
        force = self.force.quantiles(rows)
        last = int(np.flatnonzero(holds)[-1]) if holds.any() else -1
        return Told(
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
        whole = of_grasp(samples, rows, last, self.cut)
        if self.peak and np.isfinite(whole).all():
            value = float(np.exp(self.peak(whole[np.newaxis])[0]))
        return Estimate(value, *self.force_band(value, apart))


def grasp_stiffness(quantiles: np.ndarray) -> tuple[float, float]:
    """One stiffness [N/m] and how far trees lie apart, from quantiles of its logarithm, (n, 3).

    They are of the windows in which the object is held; medians over the later half of these.
    """
    later = quantiles[len(quantiles) // 2 :]
    value, apart = np.median(later[:, 1]), np.median(later[:, 2] - later[:, 0])
    return float(np.exp(value)), float(apart)


def grasp_peak(quantiles: np.ndarray) -> tuple[float, float]:
    """One peak force [N] and how far trees lie apart, from quantiles of log force, shape (3,).

    They are of the last window in which something is held.
    """
    return float(np.exp(quantiles[1])), float(quantiles[2] - quantiles[0])


def running(rigid: np.ndarray, touched: np.ndarray, hop: float) -> np.ndarray:
    """Probability in windows `hop` [s] apart, by a fading mean of their log odds.

    A motor feels an object once all fingers lie against it; the softer it is, the later. Of an
    object that is held, a window before a touch says UNFELT; of an empty hand it says nothing.
    """
    odds = np.where(touched, np.clip(log_odds(rigid), -EXTREME, EXTREME), UNFELT)
    share, mean = min(1.0, hop / FADE), np.zeros_like(odds)
    for k in range(odds.shape[-1]):
        before = mean[..., k - 1] if k else 0.0
        mean[..., k] = before + share * (odds[..., k] - before)
    return 1.0 / (1.0 + np.exp(-mean))


def log_odds(probability: np.ndarray) -> np.ndarray:
    """log p / (1 - p), finite also at 0 and 1."""
    inside = np.clip(probability, 1e-6, 1.0 - 1e-6)
    return np.log(inside) - np.log1p(-inside)


def decided(probability: np.ndarray, sure: float) -> np.ndarray:
    """SOFT, RIGID or UNKNOWN for each probability of rigid; a class from `sure` on."""
    told = np.maximum(probability, 1.0 - probability) >= sure
    return np.where(told, np.where(probability >= 0.5, RIGID, SOFT), UNKNOWN)


def plain(estimate: Estimate | None, unit: str) -> dict[str, Any] | None:
    """As JSON has it."""
    return None if estimate is None else {**vars(estimate), "unit": unit}
