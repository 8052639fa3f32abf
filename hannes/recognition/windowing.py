"""Windowing: recordings divided into windows, each with its features."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.recognition.features import CHANNELS, LEVELS, NAMES, fill, go_on

Samples = np.ndarray | Sequence[Recording]
UNITS = {"current": "A", "position": "rad", "reference": "rad"}


@dataclass(frozen=True)
class Windowing:
    """Length and hop of windows [s], sampling [Hz]; BadInput where they do not fit together."""

    window: float = 0.05
    hop: float = 0.01
    sampling: float = 1000.0

    def __post_init__(self) -> None:
        fine = self.sampling > 0.0 and self.window * self.sampling >= 4.0
        if not (fine and self.hop * self.sampling >= 1.0 and self.window <= 2.0):
            raise BadInput(
                f"window = {self.window:g} s, hop = {self.hop:g} s at {self.sampling:g} Hz: "
                "expected a window of at least 4 samples and at most 2 s, a hop of at least one"
            )

    @property
    def size(self) -> int:
        """Samples of a window."""
        return round(self.window * self.sampling)

    def ends(self, samples: int) -> np.ndarray:
        """Number of samples seen at the end of each window, ascending."""
        return np.arange(2 * self.size, samples + 1, round(self.hop * self.sampling))

    def times(self, samples: int) -> np.ndarray:
        """Time of the last sample of each window [s], from the first sample on."""
        return (self.ends(samples) - 1) / self.sampling

    def time_of(self, window: int) -> float:
        """Time of the last sample of one window [s], as `times` has it."""
        return float((self.seen(window) - 1) / self.sampling)

    def seen(self, window: int) -> int:
        """Samples at the end of one window."""
        return 2 * self.size + window * round(self.hop * self.sampling)

    def features(self, grasps: Samples) -> np.ndarray:
        """Features, shape (grasps, windows, features); NaN where a grasp has no window."""
        arrays = [self.samples(each) for each in grasps]
        most = max((self.ends(each.shape[0]).size for each in arrays), default=0)
        found = np.full((len(arrays), most, len(NAMES)), np.nan, np.float32)
        for each, rows in zip(arrays, found, strict=True):
            ends = self.ends(each.shape[0])
            fill(*each.T.copy(), 1.0 / self.sampling, self.size, ends, rows[: ends.size])
        return found

    def samples(self, grasp: Recording | np.ndarray) -> np.ndarray:
        """Current, position and reference at the sampling of the windows, shape (n, 3)."""
        if isinstance(grasp, np.ndarray):
            return _numbers(grasp)
        grasp.expect({**grasp.units, **UNITS}, CHANNELS, "recognition")
        since = grasp.time - grasp.time[0]
        if since[-1] > 600.0:
            raise BadInput(f"a grasp of {since[-1]:.0f} s: expected at most 600 s; cut it")
        grid = np.arange(int(since[-1] * self.sampling + 1e-6) + 1) / self.sampling
        return np.stack([np.interp(grid, since, grasp[name]) for name in CHANNELS], axis=1)


def _numbers(grasp: np.ndarray) -> np.ndarray:
    if grasp.ndim != 2 or grasp.shape[1] != len(CHANNELS):
        raise BadInput(f"a grasp of shape {grasp.shape}: expected (samples, 3)")
    if not np.isfinite(grasp).all():
        raise BadInput("a grasp has samples that are no numbers")
    return grasp.astype(float)


class GrowingFeatures:
    """Features of a grasp that goes on: those of `Windowing.features`, to the bit, as they come."""

    def __init__(self, windowing: Windowing) -> None:
        self._windowing, self.count = windowing, 0
        self._samples = np.empty((len(CHANNELS), 1024))
        self._level = np.zeros(1024)
        self._memory = (
            np.zeros(8), np.full(len(LEVELS), -1.0), np.array([-1, -1, 0]), np.zeros(1)
        )  # fmt: skip
        self._windows = 0

    @property
    def touch(self) -> int | None:
        """Sample of the touch, None before it was seen."""
        place = int(self._memory[2][1])
        return place if place >= 0 else None

    @property
    def samples(self) -> np.ndarray:
        """Current, position and reference so far, shape (3, count)."""
        return self._samples[:, : self.count]

    def take(self, samples: Sequence[np.ndarray]) -> list[tuple[int, np.ndarray]]:
        """Take samples of current, position, reference; give each new window and its (1, NAMES)."""
        end = self.count + len(samples)
        while end > self._level.size:
            self._samples = np.concatenate([self._samples, np.empty_like(self._samples)], axis=1)
            self._level = np.concatenate([self._level, np.zeros_like(self._level)])
        for k, each in enumerate(samples, start=self.count):
            self._samples[:, k] = each
        given = self._windowing
        hop = round(given.hop * given.sampling)
        fresh = max(0, (end - 2 * given.size) // hop + 1 - self._windows)
        first = 2 * given.size + hop * self._windows
        rows = np.zeros((fresh, len(NAMES)), np.float32)
        self._memory[2][2] = 0
        go_on(
            *self._samples, 1.0 / given.sampling, given.size, first + hop * np.arange(fresh), rows,
            (self.count, end), (self._level, *self._memory),
        )  # fmt: skip
        self.count, self._windows = end, self._windows + fresh
        return [(self._windows - fresh + k, rows[k : k + 1]) for k in range(fresh)]
