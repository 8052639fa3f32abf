"""What is done with a hand: a reference to follow, an object or none, a controller, noise."""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from hannes.core.by_value import ByValue
from hannes.core.errors import BadInput

CONTROLLERS = ("continuous", "sampled")


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Reference(ByValue):
    """Position reference at the output shaft: straight lines through knots, shape (2, n).

    Row 0 holds times [s], row 1 angles [rad]; two knots at one time make a step. `kinked` makes
    the integrator restart at every knot; a recorded reference has too many for that.
    """

    knots: np.ndarray
    kinked: bool = True

    def __init__(self, knots: ArrayLike, kinked: bool = True) -> None:
        knots = np.asarray(knots, float)
        if knots.ndim != 2 or knots.shape[0] != 2 or knots.shape[1] < 2:
            raise BadInput(f"a reference needs two rows and two knots, got shape {knots.shape}")
        if not np.isfinite(knots).all() or (np.diff(knots[0]) < 0).any():
            raise BadInput("a reference needs finite knots at times that do not decrease")
        object.__setattr__(self, "knots", np.ascontiguousarray(knots))
        object.__setattr__(self, "kinked", kinked)

    def __repr__(self) -> str:
        times, angles = self.knots
        kind = "" if self.kinked else ", smooth"
        span = f"{times[0]:g} to {times[-1]:g} s, {angles.min():g} to {angles.max():g} rad"
        return f"Reference({times.size} knots, {span}{kind})"

    def segments(self, duration: float) -> list[tuple[float, float, np.ndarray]]:
        """Split (0, duration) where the slope changes: start, end [s], knots of that part."""
        if not self.kinked:
            return [(0.0, duration, self.knots)]
        times, values = self.knots
        parts = []
        if times[0] > 0.0:
            parts.append((0.0, times[0], _line(0.0, times[0], values[0], values[0])))
        for k in range(times.size - 1):
            if times[k + 1] > times[k]:
                line = _line(times[k], times[k + 1], values[k], values[k + 1])
                parts.append((times[k], times[k + 1], line))
        parts.append((times[-1], np.inf, _line(times[-1], times[-1] + 1.0, values[-1], values[-1])))
        return [
            (max(start, 0.0), min(end, duration), line)
            for start, end, line in parts
            if start < duration and end > 0.0
        ]


def _line(start: float, end: float, first: float, last: float) -> np.ndarray:
    return np.array([[start, end], [first, last]])


@dataclass(frozen=True)
class Target:
    """An object to grasp: its shape, SI values of its `object.*` parameters, a sensor or none."""

    shape: str
    values: Mapping[str, float] = field(default_factory=dict)
    sensor: bool = False


@functools.lru_cache(maxsize=16)
def _times(duration: float, sampling: float) -> np.ndarray:
    count = math.floor(duration * sampling + 1e-6)  # of a sample: rounding
    return np.minimum(np.arange(count + 1) / sampling, duration)


@dataclass(frozen=True)
class Experiment:
    """One run of the hand; times in s, sampling in Hz, noise as standard deviations in SI."""

    title: str
    duration: float
    reference: Reference
    object: Target | None = None
    sampling: float = 1000.0
    controller: str = "continuous"
    values: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        if self.controller not in CONTROLLERS:
            raise BadInput(f'controller = "{self.controller}": expected one of {CONTROLLERS}')
        if not (self.duration > 0.0 and self.sampling > 0.0):
            raise BadInput("duration and sampling must be above zero")
        if "controller.sampled" in self.values:
            raise BadInput('controller.sampled is no value: give controller = "sampled" instead')

    @property
    def times(self) -> np.ndarray:
        """Sample times [s], shape (n,): none beyond the duration."""
        return _times(self.duration, self.sampling).copy()

    @property
    def shape(self) -> str | None:
        """Shape of the object, None where there is none."""
        return self.object.shape if self.object else None

    def overrides(self) -> dict[str, float]:
        """Parameter values this experiment asks for, by full name."""
        values = dict(self.object.values) if self.object else {}
        values["controller.sampled"] = float(self.controller == "sampled")
        return {**values, **self.values}
