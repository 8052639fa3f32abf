"""The search: rounds of least squares, each with the working covariance of the round before."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hannes.calibration.model import Model
from hannes.calibration.plan import Plan
from hannes.calibration.problem import LEAST, Problem, Scales, Stopped, missed
from hannes.calibration.starts import scattered
from hannes.calibration.whitening import Whitening
from hannes.errors import ComputationFailed

ROUNDS = 5
STILL = 0.3  # working standard deviations within which a round may move and be the last
MOST_EVALUATIONS = 60
COARSE, FINE = 1e-3, 1e-6  # relative change of the misfit at which a round ends
ROBUST = 2.0  # standard deviations beyond which a robust loss bends
LONGEST_MEMORY = 20  # bins over which what remains may hang together
RESTLESS_STEP = 3e-3  # relative difference step of what only changes from run to run

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Start:
    """One search from its own starting point under the working covariance of the second round."""

    begun: np.ndarray
    ended: np.ndarray
    cost: float


@dataclass
class Found:
    """Where the search ended, and the misfit made linear there; lists have one item for each run.

    misses: simulated minus measured, shape (n,);  columns: slopes by scaled parameter, (p, n)
    noise:  standard deviation of every channel's bins and feature, shape (names,)
    late:   when each run starts [s], shape (runs,)
    blamed: what each run did along `restless`, then its start, in standard deviations
    """

    model: Model
    plan: Plan
    scales: Scales
    x: np.ndarray
    late: np.ndarray
    noise: np.ndarray
    whitenings: list[Whitening]
    misses: list[np.ndarray]
    columns: list[np.ndarray]
    costs: list[float] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    on_bound: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    interrupted: bool = False

    @property
    def values(self) -> dict[str, float]:
        """Fitted parameters, SI."""
        return self.scales.values(self.x)


class Search:
    """One calibration in progress."""

    def __init__(
        self,
        model: Model,
        plan: Plan,
        floors: np.ndarray,
        workers: int,
        told: Progress = lambda text, misfit: None,
    ) -> None:
        self.model, self.plan, self.told = model, plan, told
        self.scales = Scales.of(plan, model.plant.parameters)
        self.floors, self.workers = np.nan_to_num(floors), workers
        self.rms = _sizes(model)
        self.best = (np.inf, np.zeros(len(plan.names)))
        self.costs: list[float] = []
        self.starts: list[Start] = []

    def run(self) -> Found:
        """Search; ComputationFailed where nothing can be simulated or it does not settle."""
        with ThreadPoolExecutor(self.workers) as pool:
            self.pool = pool
            state = self._begin()
            try:
                return self._rounds(state)
            except KeyboardInterrupt:
                x = self.best[1] if np.isfinite(self.best[0]) else state.x
                return replace(self._linear(x, state.late, state.noise), interrupted=True)

    def _begin(self) -> Found:
        """The misfit at the given values, or where a scan found it least."""
        x = np.zeros(len(self.plan.names))
        state = self._linear(x, np.zeros(len(self.model.views)), self._floor())
        if self.plan.scan:
            points = scattered(self.plan, self.scales, self.plan.scan)
            misfits = list(self.pool.map(lambda point: self._looked(state, point), points))
            self.order = [points[k] for k in np.argsort(misfits, kind="stable")]
            if min(misfits) < self._looked(state, x):
                state = self._linear(self.order.pop(0), state.late, state.noise)
        else:
            self.order = scattered(self.plan, self.scales, self.plan.starts - 1)
        return state

    def _looked(self, state: Found, x: np.ndarray) -> float:
        residual = self._problem(state, "scan", parallel=False).residual(x)
        return float(residual @ residual)

    def _rounds(self, state: Found) -> Found:
        for number in range(ROUNDS):
            self.best = (np.inf, state.x)
            before = state.x
            if number == 1 and self.plan.starts > 1:
                solved = self._from_all(state)
            else:
                problem = self._problem(state, f"round {number + 1}")
                solved = self._solve(problem, state.x, COARSE if number == 0 else FINE)
            self.costs.append(float(solved.cost))
            state = self._next(state, solved.x)
            state.on_bound = np.flatnonzero(solved.active_mask)
            if number > 0 and self._still(state, before):
                break
        if solved.status == 0:
            raise ComputationFailed(_restless(self.costs))
        return replace(state, costs=self.costs, starts=self.starts)

    def _from_all(self, state: Found) -> Any:
        """Search from here and from scattered points at once; return the best of all."""
        points = [state.x, *self.order[: self.plan.starts - 1]]
        problems = [self._problem(state, "starts", parallel=False) for _ in points]
        try:
            tasks = zip(problems, points, strict=True)
            found = list(self.pool.map(lambda task: self._tried(*task), tasks))
        except KeyboardInterrupt:
            for problem in problems:
                problem.stop.set()
            raise
        self.starts = [
            Start(point, each.x if each else point, float(each.cost) if each else np.inf)
            for point, each in zip(points, found, strict=True)
        ]
        solved = [each for each in found if each is not None]
        if not solved:
            raise ComputationFailed(_nothing_simulates())
        least = min(each.cost for each in solved)
        return next(each for each in solved if each.cost <= least * 1.001)

    def _tried(self, problem: Problem, x: np.ndarray) -> Any:
        """A search from one of several points, None where it cannot set out."""
        try:
            return self._solve(problem, x, FINE)
        except (ComputationFailed, Stopped):
            return None

    def _solve(self, problem: Problem, x: np.ndarray, tolerance: float) -> Any:
        from scipy.optimize import least_squares

        inside = np.clip(x, problem.scales.low + 1e-9, problem.scales.high - 1e-9)
        if not np.isfinite(problem.residual(inside)).all():
            raise ComputationFailed(_nothing_simulates())
        return least_squares(
            problem.residual,
            inside,
            jac=problem.jacobian,
            bounds=(problem.scales.low, problem.scales.high),
            loss=self.plan.loss,
            f_scale=ROBUST,
            ftol=tolerance,
            xtol=tolerance,
            gtol=None,
            max_nfev=MOST_EVALUATIONS,
        )

    def _problem(self, state: Found, text: str, parallel: bool = True) -> Problem:
        def told(misfit: float, x: np.ndarray) -> None:
            if misfit < self.best[0]:
                self.best = (misfit, x.copy())
            self.told(text, self.best[0])

        return Problem(
            self.model,
            self.scales,
            state.whitenings,
            state.late,
            np.full(len(self.plan.names), LEAST * 5.0),
            self.pool.map if parallel else map,
            told,
        )

    def _still(self, state: Found, before: np.ndarray) -> bool:
        """Tell whether the last round moved less than what the data can tell."""
        information = np.diag(self.scales.prior**2)
        for white, columns in zip(state.whitenings, state.columns, strict=True):
            rows = white(columns)
            information = information + rows @ rows.T
        deviation = np.sqrt(np.diag(np.linalg.inv(information)))
        return bool(np.all(np.abs(state.x - before) < STILL * deviation))

    def _next(self, state: Found, x: np.ndarray) -> Found:
        """Move the runs' starts to where they most likely are, and weigh by what remains."""
        rough = self._linear(x, state.late, state.noise)
        late = rough.late
        if self.plan.start_time:
            moves = [w.blamed(-m)[-1] for w, m in zip(rough.whitenings, rough.misses, strict=True)]
            late = late + self.plan.start_time * np.array(moves)
        return self._linear(x, late, self._remaining(rough))

    def _linear(self, x: np.ndarray, late: np.ndarray, noise: np.ndarray) -> Found:
        """Everything at x, made linear."""
        values = self.scales.values(x)
        self.model.settle(values, self.pool.map)
        columns, directions = self._slopes(values, late)
        per_run = [noise[view.part] for view in self.model.views]
        whitenings = [Whitening.of(n, d) for n, d in zip(per_run, directions, strict=True)]
        simulated = self.model.vectors(values, late, self.pool.map)
        misses = [
            missed(s, view.measured, n)
            for s, view, n in zip(simulated, self.model.views, per_run, strict=True)
        ]
        return Found(
            self.model, self.plan, self.scales, x, late, noise, whitenings, misses, columns
        )

    def _slopes(
        self, values: Mapping[str, float], late: np.ndarray
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Slopes by scaled parameters, and directions in which runs differ, for every run."""
        names, restless = self.plan.names, self.plan.nuisance
        given = self.model.plant.parameters
        steps = {n: RESTLESS_STEP * abs(values.get(n, given[n])) or s for n, s in restless.items()}
        scale = dict(zip(names, self.scales.scale, strict=True))
        steps |= {name: RESTLESS_STEP * scale[name] for name in names}
        order = list(steps)
        slopes = self.model.columns(values, late, steps, self.pool.map)
        columns = [np.array([each[order.index(n)] * scale[n] for n in names]) for each in slopes]
        moved = [
            np.array([each[order.index(n)] * s for n, s in restless.items()]).reshape(
                len(restless), each.shape[1]
            )
            for each in slopes
        ]
        if self.plan.start_time:
            delays = self.model.delays(values, late)
            moved = [
                np.vstack([each, np.nan_to_num(delay) * self.plan.start_time])
                for each, delay in zip(moved, delays, strict=True)
            ]
        return columns, moved

    def _floor(self) -> np.ndarray:
        level = np.maximum(self.floors, self.plan.model_error * self.rms)
        return np.where(level > 0.0, level, 1.0)

    def _remaining(self, state: Found) -> np.ndarray:
        """Noise by channel and feature: what remains, counted once where it hangs together."""
        rests = [w.rest(m) for w, m in zip(state.whitenings, state.misses, strict=True)]
        level = self.plan.model_error * self.rms
        for number, name in enumerate(self.model.views[0].names):
            pieces = [
                rest[view.part == number]
                for rest, view in zip(rests, self.model.views, strict=True)
            ]
            pieces = [each for each in pieces if each.size]
            if name in self.plan.channels and pieces:
                level[number] = max(level[number], _lasting(pieces))
            elif pieces:
                level[number] = max(level[number], self.floors[number])
        return np.where(level > 0.0, level, 1.0)


def _sizes(model: Model) -> np.ndarray:
    """RMS of every channel and feature over all runs [its unit], shape (names,)."""
    found = np.zeros(len(model.views[0].names))
    for number in range(found.size):
        values = np.concatenate([v.measured[v.part == number] for v in model.views])
        found[number] = np.sqrt(np.mean(values**2)) if values.size else 0.0
    return found


def _lasting(pieces: Sequence[np.ndarray]) -> float:
    """RMS of what remains, times the root of the number of bins over which it hangs together."""
    power = sum(float(each @ each) for each in pieces)
    together = 1.0
    for lag in range(1, LONGEST_MEMORY):
        shared = sum(float(each[lag:] @ each[:-lag]) for each in pieces if each.size > lag)
        if shared <= 0.05 * power:
            break
        together += 2.0 * shared / power
    count = sum(each.size for each in pieces)
    return float(np.sqrt(power / count * together))


def _restless(costs: Sequence[float]) -> str:
    path = " -> ".join(f"{each:.4g}" for each in costs[-3:])
    return (
        f"the fit did not settle (misfit {path}); try fewer parameters, values nearer to the "
        "hand's, narrower bounds, or scan = 256"
    )


def _nothing_simulates() -> str:
    return (
        "no simulation succeeds at the starting values; try base = a hand.toml that runs, "
        "narrower bounds, or fewer parameters"
    )
