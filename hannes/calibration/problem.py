"""What is made small: the whitened misfit of all runs, over scaled parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Event

import numpy as np

from hannes.calibration.model import Map, Model
from hannes.calibration.plan import Plan
from hannes.calibration.whitening import Whitening
from hannes.errors import ComputationFailed

Told = Callable[[float, np.ndarray], None]
AIM = 0.05  # change of the whitened misfit (RMS) that a difference step should make
LEAST, MOST = 3e-4, 1e-2  # of a parameter's scale
SENSELESS = 10.0  # misfit, in standard deviations, of a feature that a simulation does not have


class Stopped(Exception):
    """Somebody asked the search to end."""


@dataclass
class Scales:
    """Scaled parameters x = (value - given) / scale, their bounds and priors, shapes (p,)."""

    names: tuple[str, ...]
    given: np.ndarray
    scale: np.ndarray
    low: np.ndarray
    high: np.ndarray
    prior: np.ndarray

    @classmethod
    def of(cls, plan: Plan, given: Mapping[str, float]) -> "Scales":
        """Scales of a plan about the given values."""
        at = np.array([given[name] for name in plan.names])
        scale = np.array([plan.scale[name] for name in plan.names])
        bounds = np.array([plan.bounds[name] for name in plan.names])
        low, high = (bounds - at[:, np.newaxis]).T / scale
        spread = np.array([plan.spread[name] for name in plan.names])
        return cls(plan.names, at, scale, low, high, scale / spread)

    def values(self, x: np.ndarray) -> dict[str, float]:
        """SI values by name, inside the bounds to the last bit."""
        inside = np.clip(x, self.low, self.high)
        values = self.given + inside * self.scale
        edges = self.given + np.array([self.low, self.high]) * self.scale
        return dict(zip(self.names, np.clip(values, *edges).tolist(), strict=True))


@dataclass
class Problem:
    """The least-squares problem with a fixed working covariance; see __init__.py.

    `best` keeps the smallest misfit met and where, so that an interrupted search is not lost.
    """

    model: Model
    scales: Scales
    whitenings: Sequence[Whitening]
    late: np.ndarray
    steps: np.ndarray
    spread_over: Map = map
    told: Told = lambda misfit, x: None
    stop: Event = field(default_factory=Event)

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Whitened misfit of all runs, then the priors'; infinite where a simulation fails."""
        if self.stop.is_set():
            raise Stopped
        try:
            found = self.misses(x)
        except ComputationFailed:
            return np.full(self.size, np.inf)
        parts = [white(miss) for white, miss in zip(self.whitenings, found, strict=True)]
        whole = np.concatenate([*parts, self.scales.prior * x])
        self.told(float(np.sqrt(np.mean(whole[: self.data] ** 2))), x)
        return whole

    @property
    def data(self) -> int:
        """Number of elements that come from recordings."""
        return sum(each.noise.size for each in self.whitenings)

    @property
    def size(self) -> int:
        """Number of all elements."""
        return self.data + self.scales.prior.size

    def misses(self, x: np.ndarray) -> list[np.ndarray]:
        """Simulated minus measured of every run, shape (n,) each."""
        simulated = self.model.vectors(self.scales.values(x), self.late, self.spread_over)
        return [
            missed(s, view.measured, white.noise)
            for s, view, white in zip(simulated, self.model.views, self.whitenings, strict=True)
        ]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Slopes of `residual`, shape (size, p)."""
        if self.stop.is_set():
            raise Stopped
        rows = [
            white(columns)
            for white, columns in zip(self.whitenings, self.columns(x), strict=True)
        ]
        whole = np.hstack(rows)
        self.steps = adapted(whole)
        return np.vstack([whole.T, np.diag(self.scales.prior)])

    def columns(self, x: np.ndarray) -> list[np.ndarray]:
        """Slopes of every run by the scaled parameters, not whitened, shape (p, n) each."""
        scale = self.scales.scale
        steps = dict(zip(self.scales.names, self.steps * scale, strict=True))
        made = self.model.columns(self.scales.values(x), self.late, steps, self.spread_over)
        return [each * scale[:, np.newaxis] for each in made]


def missed(simulated: np.ndarray, measured: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Difference of two vectors; a feature that the simulation lacks counts as plainly wrong."""
    difference = simulated - measured
    return np.where(np.isnan(difference), SENSELESS * noise, difference)


def adapted(columns: np.ndarray) -> np.ndarray:
    """Difference steps [scaled] for whitened slopes (p, n): large where little moves."""
    size = np.sqrt(np.mean(columns**2, axis=1))
    return np.clip(AIM / np.maximum(size, 1e-12), LEAST, MOST)
