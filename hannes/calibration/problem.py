"""What is made small: the whitened misfit of all runs, over scaled parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Event

import numpy as np

from hannes.calibration.model import Bundle, Channels, Map, Model
from hannes.calibration.plan import Plan
from hannes.calibration.whitening import Whitening
from hannes.errors import ComputationFailed

Told = Callable[[float, np.ndarray], None]
STEP = 0.5  # of a parameter's standard deviation: slopes as they are where it may lie
LEAST, MOST = 3e-4, 3e-2  # of a parameter's scale, of a difference step
NEAR = 1e-5  # of a parameter's scale, to its bound
SENSELESS = 10.0  # misfit, in standard deviations, of a feature that a simulation does not have


class Stopped(Exception):
    """Somebody asked the search to end."""


class Settled(Exception):
    """The next step would be small against what the data can tell."""


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

    `bundle` keeps the simulations about the last point that a Jacobian was asked for. Where the
    next step is shorter than `enough` standard deviations the search ends by Settled.
    """

    model: Model
    scales: Scales
    whitenings: Sequence[Whitening]
    late: np.ndarray
    steps: np.ndarray
    spread_over: Map = map
    told: Told = lambda misfit, x: None
    stop: Event = field(default_factory=Event)
    bundle: tuple[np.ndarray, Bundle] | None = None
    enough: float = 0.0
    at: np.ndarray | None = None
    left: np.ndarray | None = None

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Whitened misfit of all runs, then the priors'; infinite where a simulation fails."""
        if self.stop.is_set():
            raise Stopped
        try:
            done = self.model.run(self.scales.values(x), self.spread_over)
        except ComputationFailed:
            return np.full(self.size, np.inf)
        whole = np.concatenate([*self.whitened(done), self.scales.prior * x])
        self.at, self.left = x.copy(), whole
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

    def whitened(self, done: Sequence[Channels]) -> list[np.ndarray]:
        """Whitened misfit of every run, shape (n,) each."""
        runs = zip(self.model.seen(done, self.late), self.model.views, self.whitenings, strict=True)
        return [white(missed(seen, view.measured, white.noise)) for seen, view, white in runs]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Slopes of `residual`, shape (size, p); raises Settled where they lead nowhere."""
        if self.stop.is_set():
            raise Stopped
        if self.bundle is None or not np.array_equal(self.bundle[0], x):
            self.bundle = x.copy(), self._bundle(x)
        columns = scaled_columns(self.model, self.bundle[1], self.scales, self.late)
        pairs = zip(self.whitenings, columns, strict=True)
        whole = np.hstack([white(each) for white, each in pairs])
        self.steps = np.clip(STEP * deviations(whole, self.scales.prior), LEAST, MOST)
        slopes = np.vstack([whole.T, np.diag(self.scales.prior)])
        if self._stands(x, slopes):
            raise Settled
        return slopes

    def _stands(self, x: np.ndarray, slopes: np.ndarray) -> bool:
        """Tell whether the step to the least misfit, were it linear, is short; bounds hold."""
        if self.left is None or self.at is None or not np.array_equal(self.at, x):
            return False
        pull = -slopes.T @ self.left
        scales = self.scales
        held = ((x - scales.low < NEAR) & (pull < 0.0)) | ((scales.high - x < NEAR) & (pull > 0.0))
        free = ~held
        curvature = slopes[:, free].T @ slopes[:, free]
        squared = float(pull[free] @ np.linalg.solve(curvature, pull[free]))
        return squared < self.enough**2

    def _bundle(self, x: np.ndarray) -> Bundle:
        steps = dict(zip(self.scales.names, self.steps * self.scales.scale, strict=True))
        return self.model.bundle(self.scales.values(x), steps, self.spread_over)


def scaled_columns(
    model: Model, bundle: Bundle, scales: Scales, late: np.ndarray
) -> list[np.ndarray]:
    """Slopes of every run by the scaled parameters, shape (p, n) each."""
    pairs = zip(scales.names, scales.scale, strict=True)
    by_name = [[s * each for each in model.slopes(bundle, n, late)] for n, s in pairs]
    return [np.array(each) for each in zip(*by_name, strict=True)]


def missed(simulated: np.ndarray, measured: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Difference of two vectors; a feature that the simulation lacks counts as plainly wrong."""
    difference = simulated - measured
    return np.where(np.isnan(difference), SENSELESS * noise, difference)


def deviations(columns: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """Standard deviations of scaled parameters under the working covariance, shape (p,).

    `columns` are whitened slopes, shape (p, n).
    """
    return np.sqrt(np.diag(np.linalg.inv(columns @ columns.T + np.diag(prior**2))))
