"""A recording under inspection: limits of its channels, noise, quantisation, speeds."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.held_rows import MOTIONS, held_rows
from hannes.campaigns.quality.conversion import Conversion, conversion
from hannes.core.recording.channel_limits import Expected
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import levels, noise, quantum

FloatArray = NDArray[np.float64]

__all__ = [
    "Plan",
    "Subject",
    "Winding",
    "alone",
    "levels",
    "noise",
    "quantum",
    "running_median",
    "speeds",
    "sustained",
    "true_runs",
]

NOTHING = Expected()
AROUND, AT_ONCE = 3, 3.0  # steps on each side, and times them, of one that stands alone
WINDOW = 9  # samples of a running median


@dataclass(frozen=True)
class Plan:
    """The command of an experiment: `times` [s] and `values`, shape (m,), lines between.

    touches: whether there is an object, which is there at that command alone.
    """

    times: FloatArray
    values: FloatArray
    touches: bool = False


@dataclass(frozen=True)
class Winding:
    """Of a motor as stated: resistance [ohm], voltage [V], constant [V s/rad] of its motion."""

    resistance: float
    voltage: float
    constant: float


@dataclass(frozen=True)
class Subject:
    """`expected` by channel, empty where no plant is known; `block` [s] is 0 there.

    asked: commanded channels, as far as the plant declares them; plan: what the experiment asks;
    needed: channels without which the plant cannot be used; winding: of its motor, if known.
    """

    recording: Recording
    expected: Mapping[str, Expected] = field(default_factory=dict)
    block: float = 0.0
    asked: frozenset[str] = frozenset()
    plan: "Plan | None" = None
    needed: frozenset[str] = frozenset()
    winding: "Winding | None" = None

    @property
    def time(self) -> FloatArray:
        """Sampling instants [s]."""
        return self.recording.time

    @cached_property
    def interval(self) -> float:
        """Median time between samples [s]."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def _speeds(self) -> dict[str, FloatArray]:
        return {}

    def speed(self, name: str) -> FloatArray:
        """Change of a channel per second, single outliers left out, shape (n - 1,)."""
        if name not in self._speeds:
            self._speeds[name] = running_median(speeds(self.time, self.recording[name]))
        return self._speeds[name]

    @cached_property
    def commands(self) -> frozenset[str]:
        """Commanded channels, not measured: they may jump and may stand still."""
        followed = {each.follows for each in self.expected.values() if each.follows}
        return frozenset(followed | self.asked | {"reference", "pulses"})

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Whether each sample repeats all measured channels though it should not, (n,)."""
        names = [name for name in self.recording.names if name not in self.commands]
        smooth = [self.is_motion(name) for name in names]
        return held_rows([self.recording[name] for name in names], smooth)

    @cached_property
    def converted(self) -> Conversion:
        """The conversion that made the recording, as far as it is known."""
        return conversion(self.recording.conversion)

    def raw(self, name: str, value: float) -> float:
        """A channel's value as its column has it, as far as the conversion is known."""
        factor, offset = self.converted.scales.get(name, (1.0, 0.0))
        return (value - offset) / factor

    @property
    def planned(self) -> FloatArray | None:
        """The experiment's command, None where it is not known."""
        return None if self.plan is None else self.plan.values

    def asked_of(self, moved: str) -> FloatArray | None:
        """The command that a motion follows, recorded or of the experiment, (n,)."""
        found = self.asked_at(moved)
        return None if found is None else np.interp(self.time, *found)

    def asked_at(self, moved: str) -> tuple[FloatArray, FloatArray] | None:
        """Times [s] and values of the command that a motion follows, each (m,)."""
        command = self.of(moved).follows
        if command and command in self.recording:
            return self.time, self.recording[command]
        if not command or self.plan is None:
            return None
        return self.plan.times, self.plan.values

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


def alone(steps: FloatArray, least: float) -> NDArray[np.bool_]:
    """Whether each step is far larger than those around it, and than `least`, (n,)."""
    from scipy.ndimage import maximum_filter1d

    size = np.abs(steps)
    before = maximum_filter1d(size, AROUND, origin=AROUND // 2, mode="nearest")
    after = maximum_filter1d(size, AROUND, origin=-(AROUND // 2), mode="nearest")
    near = np.maximum(np.r_[0.0, before[:-1]], np.r_[after[1:], 0.0])
    return np.asarray((size > least) & (size > AT_ONCE * near))


def true_runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
