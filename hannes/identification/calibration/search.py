"""The search: rounds of least squares, each with the working covariance of the round before."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.calibration import model_error
from hannes.identification.calibration.joint_steps import joint_steps
from hannes.identification.calibration.least_squares import NOTHING_SIMULATES, Solved, solve
from hannes.identification.calibration.linearisation import Maker, Start, State
from hannes.identification.calibration.objective import Problem, Stopped, deviations
from hannes.identification.calibration.scaling import Scales
from hannes.identification.calibration.settings import Plan
from hannes.identification.calibration.simulator import Model
from hannes.identification.calibration.starting_points import scattered
from hannes.identification.calibration.tuning import CALIBRATION

Progress = Callable[[str, float], None]


class Search:
    """One calibration in progress."""

    def __init__(
        self,
        model: Model,
        plan: Plan,
        noise_floors: np.ndarray,
        workers: int,
        progress: Progress = lambda text, rms: None,
    ) -> None:
        self.model, self.plan, self.progress, self.workers = model, plan, progress, workers
        self.scales = Scales.of(plan, model.plant.parameters)
        self.noise_floors = np.nan_to_num(noise_floors)
        self.least = plan.model_error * model_error.sizes(model)
        self.best = (np.inf, np.zeros(len(plan.names)))
        self.costs: list[float] = []
        self.starts: list[Start] = []

    def run(self) -> State:
        """Search; ComputationFailed where nothing can be simulated or the fit does not converge."""
        with ThreadPoolExecutor(self.workers) as self.pool:
            self.maker = Maker(self.model, self.plan, self.scales, self.pool.map)
            state = self._begin()
            try:
                found = self._rounds(state)
            except KeyboardInterrupt:
                x = self.best[1] if np.isfinite(self.best[0]) else state.x
                found = replace(self.maker.at(x, state), interrupted=True)
        return replace(found, costs=self.costs, starts=self.starts, noise_floors=self.noise_floors)

    def _begin(self) -> State:
        """The state at the nominal values, or at the best point of a scan."""
        x = np.zeros(len(self.plan.names))
        try:
            state = self.maker.first(x, model_error.first(self.least, self.noise_floors))
        except ComputationFailed as error:
            raise ComputationFailed(f"{NOTHING_SIMULATES} ({error})") from None
        self.order = scattered(self.plan, self.scales, self.plan.scan or self.plan.starts - 1)
        if not self.plan.scan:
            return state
        sums = list(self.pool.map(lambda point: self._looked(state, point), self.order))
        self.order = [self.order[k] for k in np.argsort(sums, kind="stable")]
        if min(sums) < self._looked(state, x):
            return self.maker.at(self.order.pop(0), state)
        return state

    def _looked(self, state: State, x: np.ndarray) -> float:
        residual = self._problem(state, "scan", parallel=False).residual(x)
        return float(residual @ residual)

    def _rounds(self, state: State) -> State:
        for number in range(CALIBRATION.max_rounds):
            self.best, before = (np.inf, state.x), state.x
            if number == 1 and self.plan.starts > 1:
                solved, problem = self._from_all(state)
            else:
                problem = self._problem(state, f"round {number + 1}")
                solved = solve(
                    problem, state.x, *(() if number else (CALIBRATION.coarse_tolerance,))
                )
            self.costs.append(solved.cost)
            state = self._next(state, solved, problem)
            if number > 0 and self._still(state, before):
                break
        if not solved.settled:
            raise ComputationFailed(_unsettled(self.costs))
        return state

    def _from_all(self, state: State) -> tuple[Solved, Problem]:
        """Search from here and from scattered points at once; return the best of all."""
        points = [state.x, *self.order[: self.plan.starts - 1]]
        problems = [self._problem(state, "starts", parallel=False) for _ in points]
        try:
            tasks = zip(problems, points, strict=True)
            found = list(self.pool.map(lambda task: _tried(*task), tasks))
        except KeyboardInterrupt:
            for problem in problems:
                problem.stop.set()
            raise
        self.starts = [
            Start(point, each.x if each else point, each.cost if each else np.inf)
            for point, each in zip(points, found, strict=True)
        ]
        least = min(each.cost for each in self.starts)
        for solved, problem in zip(found, problems, strict=True):
            if solved is not None and solved.cost <= least * CALIBRATION.as_good:
                return solved, problem
        raise ComputationFailed(NOTHING_SIMULATES)

    def _problem(self, state: State, text: str, parallel: bool = True) -> Problem:
        def progress(rms: float, x: np.ndarray) -> None:
            if rms < self.best[0]:
                self.best = (rms, x.copy())
            self.progress(text, self.best[0])

        return Problem(state, self.pool.map if parallel else map, progress)

    def _next(self, state: State, solved: Solved, problem: Problem) -> State:
        """The state where the round ended, with new start offsets, uncertain values and noise."""
        at, bundle = problem.bundle
        if not np.array_equal(at, solved.x):
            bundle = self.maker.bundle(solved.x, state.uncertain_values, problem.steps)
        made = self.maker.solved(state, solved.x, problem.steps, bundle)
        offsets = made.start_offsets + made.start_corrections()
        made = self.maker.moved(made, offsets, made.simulated_uncertain_values())
        if self.plan.uncertain:
            made = joint_steps(self.maker, made)
        made = self.maker.weighed(made, model_error.remaining(made, self.least, self.noise_floors))
        return replace(made, on_bound=solved.on_bound)

    def _still(self, state: State, before: np.ndarray) -> bool:
        """Whether the last round moved less than what the data resolve."""
        deviation = deviations(state.jacobian(), self.scales.prior)
        return bool(np.all(np.abs(state.x - before) < CALIBRATION.still * deviation))


def _tried(problem: Problem, x: np.ndarray) -> Solved | None:
    """A search from one of several points; None where it cannot start."""
    try:
        return solve(problem, x)
    except (ComputationFailed, Stopped):
        return None


def _unsettled(costs: Sequence[float]) -> str:
    path = " -> ".join(f"{each:.4g}" for each in costs[-3:])
    return (
        f"the fit did not converge (cost {path}); try fewer parameters, values nearer to the "
        "hand's, narrower bounds, or scan = 256"
    )
