"""A recording under inspection: limits of its channels, noise, quantisation, speeds."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness

FloatArray = NDArray[np.float64]

NOTHING = Expected()
MOTIONS = ("rad", "m", "deg", "mm")  # units of positions, which inertia keeps from jumping
WINDOW = 9  # samples of a running median
ALTERNATES = 0.55  # share of sign changes that separates noise from curvature
FEWEST_SIGNS = 10
ROUNDING = 1e-7  # of the range; less is the rounding of digits
FINEST = 1e-5  # of the range; a smaller quantisation step is ignored


@dataclass(frozen=True)
class Subject:
    """`expected` by channel, empty where no plant is known; `block` [s] is 0 there.

    asked: commanded channels, as far as the plant declares them.
    """

    recording: Recording
    expected: Mapping[str, Expected] = field(default_factory=dict)
    block: float = 0.0
    asked: frozenset[str] = frozenset()

    @property
    def time(self) -> FloatArray:
        """Sampling instants [s]."""
        return self.recording.time

    @cached_property
    def interval(self) -> float:
        """Median time between samples [s]."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def commands(self) -> frozenset[str]:
        """Commanded channels, not measured: they may jump and may stand still."""
        followed = {each.follows for each in self.expected.values() if each.follows}
        return frozenset(followed | self.asked | {"reference", "pulses"})

    def of(self, name: str) -> Expected:
        """Plausible limits of a channel."""
        return self.expected.get(name, NOTHING)

    def is_motion(self, name: str) -> bool:
        """Whether a channel is a measured position, which cannot jump."""
        measured = name not in self.commands
        return measured and (bool(self.of(name).follows) or self.recording.units[name] in MOTIONS)

    def with_unit(self, value: float, name: str) -> str:
        """A value with the channel's unit."""
        unit = self.recording.units[name]
        return f"{value:.4g}" if unit == "1" else f"{value:.4g} {unit}"


def noise(values: FloatArray) -> float:
    """Standard deviation of white noise from second differences; 0 for a smooth signal.

    The second difference of white noise changes sign 73 times in 100 samples (its correlation
    from one to the next is -2/3), that of a smooth signal hardly ever.
    """
    second = np.diff(values, 2)
    signs = np.sign(second[second != 0.0])
    if signs.size < FEWEST_SIGNS or np.mean(signs[1:] != signs[:-1]) < ALTERNATES:
        return 0.0
    size = roughness(values)
    return size if size > ROUNDING * float(np.ptp(values)) else 0.0


def quantum(values: FloatArray) -> float:
    """Quantisation step, 0 where none is visible."""
    levels = np.unique(values)
    if levels.size < 3:
        return 0.0
    span = float(levels[-1] - levels[0])
    gaps = np.diff(levels)
    gaps = gaps[gaps > FINEST * span]
    if gaps.size < 2:
        return 0.0
    multiples = gaps / gaps.min()
    off = np.abs(multiples - np.round(multiples)) > 0.05
    return float(np.median(gaps / np.round(multiples))) if off.mean() < 0.01 else 0.0


def speeds(time: FloatArray, values: FloatArray) -> FloatArray:
    """Change per time from sample to sample, shape (n - 1,)."""
    return np.asarray(np.diff(values) / np.diff(time))


def sustained(speed: FloatArray) -> float:
    """Fastest speed over some samples: single outliers do not count."""
    return float(running_median(np.abs(speed)).max())


def running_median(values: FloatArray) -> FloatArray:
    """Median over WINDOW samples around each, shape (n,)."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(values, size=WINDOW, mode="nearest"))


def true_runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
