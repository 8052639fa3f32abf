"""The residual linearised about one point: where a round of the search starts and ends."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hannes.identification.calibration.scaling import Scales
from hannes.identification.calibration.settings import Plan
from hannes.identification.calibration.simulator import Bundle, Map, Model
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.identification.whitening import Whitening
from hannes.plants.protocol import Plant


@dataclass(frozen=True)
class Start:
    """One search from its own starting point, and where it ended."""

    begun: np.ndarray
    ended: np.ndarray
    cost: float


@dataclass
class State:
    """Everything about one point x; lists have one item for each run.

    start_offsets:    when each run starts [s], shape (runs,)
    uncertain_values: of uncertain parameters that are not asked for, in standard deviations from
                      their nominal values, shape (q,); those of single parts are never simulated
                      and stay 0
    noise:            standard deviation of every channel's bins and feature, shape (names,)
    steps:            scaled difference steps, shape (p,)
    bundle:           simulations about x
    slow:             simulations about slow_at, for derivatives that change little
    residuals:        simulated minus measured, shape (n,)
    columns:          derivatives by scaled parameter, shape (p, n)
    uncertain_columns: by uncertain parameter, shape (q, n)
    """

    model: Model
    plan: Plan
    scales: Scales
    x: np.ndarray
    start_offsets: np.ndarray
    uncertain_values: np.ndarray
    noise: np.ndarray
    steps: np.ndarray
    bundle: Bundle
    slow: Bundle | None
    slow_at: np.ndarray
    whitenings: list[Whitening]
    residuals: list[np.ndarray]
    columns: list[np.ndarray]
    uncertain_columns: list[np.ndarray]
    costs: list[float] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    on_bound: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    noise_floors: np.ndarray = field(default_factory=lambda: np.zeros(0))
    interrupted: bool = False

    @cached_property
    def shared(self) -> Whitening | None:
        """Whitens all runs together against the uncertain parameters, if any."""
        if not len(self.uncertain_columns[0]):
            return None
        runs = zip(self.whitenings, self.uncertain_columns, strict=True)
        whole = np.hstack([white(rows) for white, rows in runs])
        return Whitening.of(np.ones(whole.shape[1]), whole)

    @property
    def values(self) -> dict[str, float]:
        """Fitted parameters, SI."""
        return self.scales.values(self.x)

    @property
    def all_values(self) -> dict[str, float]:
        """Fitted and uncertain parameters, SI."""
        return {
            **uncertain_parameters(self.model.plant, self.plan, self.uncertain_values),
            **self.values,
        }

    def jacobian(self) -> np.ndarray:
        """Whitened derivatives of all runs by the scaled parameters, shape (p, N)."""
        return self.together(self.columns)

    def together(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of all runs, whitened by run and then against uncertain parameters, (..., N)."""
        pairs = zip(self.whitenings, rows, strict=True)
        whole = np.concatenate([white(each) for white, each in pairs], axis=-1)
        return self.shared(whole) if self.shared else whole

    def whitened_residual(self, residuals: Sequence[np.ndarray]) -> np.ndarray:
        """Whitened residual of all runs, uncertain parameters at their nominal values, (N,)."""
        if not self.shared:
            return self.together(residuals)
        pairs = zip(residuals, self.uncertain_columns, strict=True)
        return self.together([residual - self.uncertain_values @ rows for residual, rows in pairs])

    def whitened_residuals(self) -> list[np.ndarray]:
        """Whitened residual of each run, uncertain parameters where they fit best, (n,) each."""
        moved = self.best_uncertain_values() - self.uncertain_values
        runs = zip(self.whitenings, self.residuals, self.uncertain_columns, strict=True)
        return [white(residual + moved @ rows) for white, residual, rows in runs]

    def best_uncertain_values(self) -> np.ndarray:
        """Most likely uncertain parameters, in standard deviations, shape (q,)."""
        if not self.shared:
            return self.uncertain_values
        runs = zip(self.whitenings, self.residuals, self.uncertain_columns, strict=True)
        whole = [white(residual - self.uncertain_values @ rows) for white, residual, rows in runs]
        return self.shared.attributed(-np.concatenate(whole))

    def simulated_uncertain_values(self) -> np.ndarray:
        """The same of uncertain parameters; 0 for single parts, which no simulation has, (q,)."""
        found = self.best_uncertain_values().copy()
        found[len(self.plan.doubt) :] = 0.0
        return found

    def start_corrections(self) -> np.ndarray:
        """How much later than assumed each run most likely starts [s], shape (runs,)."""
        if not self.plan.start_time:
            return np.zeros(len(self.residuals))
        pairs = zip(self.whitenings, self.residuals, strict=True)
        found = np.array([white.attributed(-residual)[-1] for white, residual in pairs])
        return self.plan.start_time * found

    @property
    def rms(self) -> float:
        """RMS of the whitened residual of all runs."""
        return float(np.sqrt(np.mean(np.concatenate(self.whitened_residuals()) ** 2)))


def uncertain_parameters(
    plant: Plant, plan: Plan, uncertain_values: np.ndarray
) -> dict[str, float]:
    """SI values of the uncertain parameters, inside their bounds."""
    found = {}
    for (name, size), at in zip(plan.doubt.items(), uncertain_values, strict=False):
        low, high = plant.parameters.declared[name].bounds
        found[name] = float(np.clip(plant.parameters[name] + size * at, low, high))
    return found


@dataclass
class Maker:
    """Makes states: simulates about points on the threads of `spread_over`."""

    model: Model
    plan: Plan
    scales: Scales
    spread_over: Map

    def values(self, x: np.ndarray, uncertain_values: np.ndarray) -> dict[str, float]:
        """What is simulated at a point, SI."""
        return {
            **uncertain_parameters(self.model.plant, self.plan, uncertain_values),
            **self.scales.values(x),
        }

    def bundle(self, x: np.ndarray, uncertain_values: np.ndarray, steps: np.ndarray) -> Bundle:
        """Simulations about a point for the derivatives by all parameters."""
        sizes = dict(zip(self.plan.names, steps * self.scales.scale, strict=True))
        values, made = self.values(x, uncertain_values), None
        if self.plan.uncertain:
            made = self.model.sloped(values, sizes, self.spread_over)
        return made or self.model.bundle(values, sizes, self.spread_over)

    def slow(self, x: np.ndarray, uncertain_values: np.ndarray) -> Bundle:
        """Simulations for run-to-run variability and uncertain parameters."""
        values, given = self.values(x, uncertain_values), self.model.plant.parameters
        sizes: Mapping[str, float] = {**self.plan.nuisance, **self.plan.doubt}
        if self.plan.uncertain:
            steps = {name: CALIBRATION.difference_step * size for name, size in sizes.items()}
            if made := self.model.sloped(values, steps, self.spread_over):
                return made
        steps = {
            name: CALIBRATION.first_step * abs(values.get(name, given[name])) or size
            for name, size in sizes.items()
        }
        return self.model.bundle(values, steps, self.spread_over)

    def first(self, x: np.ndarray, noise: np.ndarray) -> State:
        """The state at x with noise alone: no run-to-run variability, all parameters certain."""
        start_offsets, steps = (
            np.zeros(len(self.model.views)),
            np.full(x.size, CALIBRATION.first_step),
        )
        uncertain_values = np.zeros(len(self.plan.uncertain))
        bundle = self.bundle(x, uncertain_values, steps)
        self.model.settle(self.values(x, uncertain_values), bundle.centre, self.spread_over)
        return self.made(x, start_offsets, uncertain_values, noise, steps, bundle, None, x)

    def at(self, x: np.ndarray, state: State) -> State:
        """The state at another x, all else unchanged."""
        bundle = self.bundle(x, state.uncertain_values, state.steps)
        self.model.settle(self.values(x, state.uncertain_values), bundle.centre, self.spread_over)
        slow = state.slow or self.slow(x, state.uncertain_values)
        return self.made(
            x, state.start_offsets, state.uncertain_values, state.noise, state.steps,
            bundle, slow, state.slow_at,
        )  # fmt: skip

    def moved(self, state: State, start_offsets: np.ndarray, uncertain_values: np.ndarray) -> State:
        """The state with other start offsets and uncertain values."""
        bundle = state.bundle
        if self.plan.doubt:
            bundle = self.bundle(state.x, uncertain_values, state.steps)
            self.model.settle(
                self.values(state.x, uncertain_values), bundle.centre, self.spread_over
            )
        return self.made(
            state.x, start_offsets, uncertain_values, state.noise, state.steps,
            bundle, state.slow, state.slow_at,
        )  # fmt: skip

    def anew(self, state: State, x: np.ndarray, uncertain_values: np.ndarray) -> State:
        """The state at another x and other uncertain values, all derivatives there."""
        bundle = self.bundle(x, uncertain_values, state.steps)
        self.model.settle(self.values(x, uncertain_values), bundle.centre, self.spread_over)
        return self.made(
            x, state.start_offsets, uncertain_values, state.noise, state.steps,
            bundle, self.slow(x, uncertain_values), x,
        )  # fmt: skip

    def weighed(self, state: State, noise: np.ndarray) -> State:
        """The state with other noise."""
        made = self.made(
            state.x, state.start_offsets, state.uncertain_values, noise, state.steps,
            state.bundle, state.slow, state.slow_at,
        )  # fmt: skip
        return replace(made, on_bound=state.on_bound)

    def solved(self, state: State, x: np.ndarray, steps: np.ndarray, bundle: Bundle) -> State:
        """The state at x, with `bundle` simulated about it; new slow derivatives where x is far."""
        self.model.settle(self.values(x, state.uncertain_values), bundle.centre, self.spread_over)
        slow, slow_at = state.slow, state.slow_at
        if slow is None or np.abs(x - slow_at).max() > CALIBRATION.same_slow_derivatives:
            slow, slow_at = self.slow(x, state.uncertain_values), x
        return self.made(
            x, state.start_offsets, state.uncertain_values, state.noise, steps,
            bundle, slow, slow_at,
        )  # fmt: skip

    def made(
        self,
        x: np.ndarray,
        start_offsets: np.ndarray,
        uncertain_values: np.ndarray,
        noise: np.ndarray,
        steps: np.ndarray,
        bundle: Bundle,
        slow: Bundle | None,
        slow_at: np.ndarray,
    ) -> State:
        """A state from its simulations."""
        model, views = self.model, self.model.views
        per_run = [
            np.hypot(noise[view.part], CALIBRATION.nonlinearity * nonlinearity)
            for view, nonlinearity in zip(views, model.nonlinearities(bundle.centre), strict=True)
        ]
        vectors = model.vectors(bundle.centre, start_offsets)
        runs = zip(vectors, views, per_run, strict=True)
        residuals = [residual_vector(values, view.measured, n) for values, view, n in runs]
        moved = self._stacked(slow, self.plan.nuisance, start_offsets)
        if self.plan.start_time:
            delays = model.delays(bundle.centre, start_offsets)
            pairs = zip(moved, delays, strict=True)
            moved = [np.vstack([rows, self.plan.start_time * delay]) for rows, delay in pairs]
        whitenings = [Whitening.of(n, rows) for n, rows in zip(per_run, moved, strict=True)]
        uncertain_columns = self._stacked(slow, self.plan.uncertain, start_offsets)
        return State(
            model, self.plan, self.scales, x, start_offsets, uncertain_values, noise, steps,
            bundle, slow, slow_at,
            whitenings, residuals, self.columns(bundle, start_offsets), uncertain_columns,
        )  # fmt: skip

    def columns(self, bundle: Bundle, start_offsets: np.ndarray) -> list[np.ndarray]:
        """Derivatives of every run by the scaled parameters, shape (p, n) each."""
        scale = dict(zip(self.plan.names, self.scales.scale.tolist(), strict=True))
        return self._stacked(bundle, scale, start_offsets)

    def _stacked(
        self, bundle: Bundle | None, sizes: Mapping[str, float], start_offsets: np.ndarray
    ) -> list[np.ndarray]:
        """Derivatives by each parameter times its size, for every run, shape (sizes, n) each."""
        if bundle is None or not sizes:
            return [np.zeros((0, view.measured.size)) for view in self.model.views]
        return self.model.derivatives(bundle, sizes, start_offsets)


def residual_vector(simulated: np.ndarray, measured: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Difference of two vectors; a feature that the simulation lacks counts as plainly wrong."""
    difference = simulated - measured
    return np.where(np.isnan(difference), CALIBRATION.missing_feature * noise, difference)
