"""The objective of a round: the whitened residual of all runs, over scaled parameters."""

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.calibration.linearisation import Maker, State, residual_vector
from hannes.identification.calibration.simulator import Bundle, Channels, Map
from hannes.identification.calibration.tuning import CALIBRATION

Progress = Callable[[float, np.ndarray], None]


class Stopped(Exception):
    """The search was asked to end."""


class Settled(Exception):
    """The next step would be small against what the data resolve."""


@dataclass
class Problem:
    """Least squares with the working covariance of `state`; see __init__.py.

    `bundle` keeps a point and the simulations about it: derivatives come from them while a search
    stays close. `last` keeps the last point that a residual was asked for, and the residual.
    Several threads may ask for residuals.
    """

    state: State
    spread_over: Map = map
    progress: Progress = lambda rms, x: None
    stop: Event = field(default_factory=Event)
    bundle: tuple[np.ndarray, Bundle] = field(init=False)
    steps: np.ndarray = field(init=False)
    last: tuple[np.ndarray, np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        state = self.state
        self.bundle, self.steps = (state.x, state.bundle), state.steps
        self.last = (np.zeros(0), np.zeros(0))
        self.maker = Maker(state.model, state.plan, state.scales, self.spread_over)

    def residual(self, x: np.ndarray) -> np.ndarray:
        """Whitened residual of all runs, then the priors'; infinite where a simulation fails."""
        if self.stop.is_set():
            raise Stopped
        at, left = self.last
        if np.array_equal(at, x):  # searches ask again where they begin and where they end
            return left
        state = self.state
        try:
            values = self.maker.values(x, state.uncertain_values)
            done = state.model.run(values, self.spread_over)
        except ComputationFailed:
            return np.full(sum(each.size for each in state.residuals) + x.size, np.inf)
        data = state.whitened_residual(self._misses(done))
        left = np.concatenate([data, state.scales.prior * x])
        self.last = x.copy(), left
        self.progress(float(np.sqrt(np.mean(data**2))), x)
        return left

    def _misses(self, done: list[Channels]) -> list[np.ndarray]:
        state = self.state
        vectors = state.model.vectors(done, state.start_offsets)
        runs = zip(vectors, state.model.views, state.whitenings, strict=True)
        return [residual_vector(values, view.measured, white.noise) for values, view, white in runs]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivatives of `residual`, shape (size, p); raises Settled where they lead nowhere."""
        if self.stop.is_set():
            raise Stopped
        state = self.state
        if np.abs(self.bundle[0] - x).max() > CALIBRATION.same_derivatives:
            self.bundle = x.copy(), self.maker.bundle(x, state.uncertain_values, self.steps)
        columns = self.maker.columns(self.bundle[1], state.start_offsets)
        whole = state.together(columns)
        deviation = deviations(whole, state.scales.prior)
        self.steps = np.clip(
            CALIBRATION.difference_step * deviation,
            CALIBRATION.least_step,
            CALIBRATION.largest_step,
        )
        jacobian = np.vstack([whole.T, np.diag(state.scales.prior)])
        at, left = self.last
        if np.array_equal(at, x) and self._stands(x, left, jacobian):
            raise Settled
        return jacobian

    def _stands(self, x: np.ndarray, left: np.ndarray, jacobian: np.ndarray) -> bool:
        """Whether the step to the least cost, were it linear, is short; bounds hold."""
        gradient, scales = -jacobian.T @ left, self.state.scales
        held = (x - scales.low < CALIBRATION.at_bound) & (gradient < 0.0)
        held |= (scales.high - x < CALIBRATION.at_bound) & (gradient > 0.0)
        free = ~held
        hessian = jacobian[:, free].T @ jacobian[:, free]
        return bool(
            gradient[free] @ np.linalg.solve(hessian, gradient[free]) < CALIBRATION.short_step**2
        )


def deviations(columns: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """Standard deviations of scaled parameters under the working covariance, shape (p,).

    `columns` are whitened derivatives, shape (p, n).
    """
    return np.sqrt(np.diag(np.linalg.inv(columns @ columns.T + np.diag(prior**2))))
