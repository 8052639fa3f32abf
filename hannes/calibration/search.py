"""The search: rounds of least squares, each with the working covariance of the round before."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from hannes.calibration.model import Bundle, Model
from hannes.calibration.plan import Plan
from hannes.calibration.problem import (
    NEAR,
    Problem,
    Scales,
    Settled,
    Stopped,
    deviations,
    missed,
    scaled_columns,
)
from hannes.calibration.starts import scattered
from hannes.calibration.view import View
from hannes.calibration.whitening import Whitening
from hannes.errors import ComputationFailed
from hannes.plant import expectations

ROUNDS = 5
STILL = 0.3  # standard deviations within which a round may move and be the last
MOST_EVALUATIONS = 40
ENOUGH = 0.1  # standard deviations: a step shorter than this ends a round
COARSE, FINE = 0.1, 1e-5  # relative gain that ends the first round, whose weights are wrong; others
JERK = 10.0  # times a simulated jerk inside a bin is taken as noise there
ROBUST = 2.0  # standard deviations beyond which a robust loss bends
FIRST_STEP = 2e-3  # of a parameter's scale, of differences before anything is known
FAR = 0.05  # of a parameter's scale, from where directions in which runs differ are had anew
_NOTHING_SIMULATES = (
    "no simulation succeeds at the starting values; try base = a hand.toml that runs, narrower "
    "bounds, or fewer parameters"
)

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Solved:
    """Where one least-squares search ended: scaled x, cost, places of those at a bound."""

    x: np.ndarray
    cost: float
    on_bound: np.ndarray
    settled: bool


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
    steps: np.ndarray
    bundle: Bundle
    restless: Bundle | None
    restless_at: np.ndarray
    costs: list[float] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    on_bound: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    floors: np.ndarray = field(default_factory=lambda: np.zeros(0))
    interrupted: bool = False

    @property
    def misfit(self) -> float:
        """RMS of the whitened misfit of all runs."""
        pairs = zip(self.whitenings, self.misses, strict=True)
        return float(np.sqrt(np.mean(np.concatenate([w(m) for w, m in pairs]) ** 2)))

    @property
    def values(self) -> dict[str, float]:
        """Fitted parameters, SI."""
        return self.scales.values(self.x)

    def delays_blamed(self) -> np.ndarray:
        """How much later than assumed each run starts, in standard deviations, shape (runs,)."""
        if not self.plan.start_time:
            return np.zeros(len(self.misses))
        pairs = zip(self.whitenings, self.misses, strict=True)
        return np.array([white.blamed(-miss)[-1] for white, miss in pairs])


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
        with ThreadPoolExecutor(self.workers) as self.pool:
            state = self._begin()
            try:
                found = self._rounds(state)
            except KeyboardInterrupt:
                x = self.best[1] if np.isfinite(self.best[0]) else state.x
                found = replace(self._linear(x, state), interrupted=True)
        return replace(found, costs=self.costs, starts=self.starts, floors=self.floors)

    def _begin(self) -> Found:
        """The misfit at the given values, or where a scan found it least."""
        x, late = np.zeros(len(self.plan.names)), np.zeros(len(self.model.views))
        try:
            state = self._first(x, late)
        except ComputationFailed as error:
            raise ComputationFailed(f"{_NOTHING_SIMULATES} ({error})") from None
        self.order = scattered(self.plan, self.scales, self.plan.scan or self.plan.starts - 1)
        if not self.plan.scan:
            return state
        misfits = list(self.pool.map(lambda point: self._looked(state, point), self.order))
        self.order = [self.order[k] for k in np.argsort(misfits, kind="stable")]
        least = min(misfits)
        return self._linear(self.order.pop(0), state) if least < self._looked(state, x) else state

    def _looked(self, state: Found, x: np.ndarray) -> float:
        residual = self._problem(state, "scan", parallel=False).residual(x)
        return float(residual @ residual)

    def _rounds(self, state: Found) -> Found:
        for number in range(ROUNDS):
            self.best, before = (np.inf, state.x), state.x
            several = number == 1 and self.plan.starts > 1
            text = f"round {number + 1}"
            solved, problem = (
                self._from_all(state)
                if several
                else self._solve(self._problem(state, text), state.x, FINE if number else COARSE)
            )
            self.costs.append(solved.cost)
            state = self._next(state, solved.x, problem)
            state.on_bound = solved.on_bound
            if number > 0 and self._still(state, before):
                break
        if not solved.settled:
            raise ComputationFailed(_unsettled(self.costs))
        return state

    def _from_all(self, state: Found) -> tuple[Solved, Problem]:
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
            Start(point, each.x if each else point, each.cost if each else np.inf)
            for point, each in zip(points, found, strict=True)
        ]
        least = min(each.cost for each in self.starts)
        for solved, problem in zip(found, problems, strict=True):
            if solved is not None and solved.cost <= least * 1.001:
                return solved, problem
        raise ComputationFailed(_NOTHING_SIMULATES)

    def _tried(self, problem: Problem, x: np.ndarray) -> Solved | None:
        """A search from one of several points, None where it cannot set out."""
        try:
            return self._solve(problem, x, FINE)[0]
        except (ComputationFailed, Stopped):
            return None

    def _solve(self, problem: Problem, x: np.ndarray, tolerance: float) -> tuple[Solved, Problem]:
        from scipy.optimize import least_squares

        low, high = problem.scales.low, problem.scales.high
        inside = np.clip(x, low + 1e-9, high - 1e-9)
        if not np.isfinite(problem.residual(inside)).all():
            raise ComputationFailed(_NOTHING_SIMULATES)
        problem.enough = ENOUGH
        try:
            found = least_squares(
                problem.residual,
                inside,
                jac=problem.jacobian,
                bounds=(low, high),
                loss=self.plan.loss,
                f_scale=ROBUST,
                ftol=tolerance,
                xtol=FINE,
                gtol=None,
                max_nfev=MOST_EVALUATIONS,
            )
            at, settled = found.x, found.status > 0
        except Settled:
            assert problem.at is not None
            at, settled = problem.at, True
        left = problem.residual(at)
        on_bound = np.flatnonzero((at - low < NEAR) | (high - at < NEAR))
        return Solved(at, cost(self.plan.loss, left), on_bound, settled), problem

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
            state.steps,
            self.pool.map if parallel else map,
            told,
            bundle=(state.x, state.bundle),
        )

    def _still(self, state: Found, before: np.ndarray) -> bool:
        """Tell whether the last round moved less than what the data can tell."""
        pairs = zip(state.whitenings, state.columns, strict=True)
        whole = np.hstack([white(columns) for white, columns in pairs])
        deviation = deviations(whole, self.scales.prior)
        return bool(np.all(np.abs(state.x - before) < STILL * deviation))

    def _first(self, x: np.ndarray, late: np.ndarray) -> Found:
        """Everything at x, before anything is known of what remains."""
        steps = np.full(x.size, FIRST_STEP)
        level = np.maximum(self.floors, self.plan.model_error * self.rms)
        noise = np.where(level > 0.0, level, 1.0)
        bundle = self._bundle(x, steps)
        self.model.settle(self.scales.values(x), bundle.base, self.pool.map)
        return self._made(x, late, noise, steps, bundle, None)

    def _linear(self, x: np.ndarray, state: Found) -> Found:
        """Everything at x, with noise and starts as they were."""
        bundle = self._bundle(x, state.steps)
        self.model.settle(self.scales.values(x), bundle.base, self.pool.map)
        return self._made(x, state.late, state.noise, state.steps, bundle, self._restless(x))

    def _next(self, state: Found, x: np.ndarray, problem: Problem) -> Found:
        """Move the runs' starts to where they most likely are, and weigh by what remains."""
        known = problem.bundle
        if known is None or not np.array_equal(known[0], x):
            known = x, self._bundle(x, problem.steps)
        self.model.settle(self.scales.values(x), known[1].base, self.pool.map)
        far = state.restless is None or np.abs(x - state.restless_at).max() > FAR
        restless = self._restless(x) if far else state.restless
        at = x if far else state.restless_at
        rough = self._made(x, state.late, state.noise, problem.steps, known[1], restless)
        late = state.late + self.plan.start_time * rough.delays_blamed()
        made = self._made(x, late, self._remaining(rough), problem.steps, known[1], restless)
        made.restless_at = at
        return made

    def _bundle(self, x: np.ndarray, steps: np.ndarray) -> Bundle:
        """Simulations about x for the slopes by all parameters."""
        sizes = dict(zip(self.plan.names, steps * self.scales.scale, strict=True))
        return self.model.bundle(self.scales.values(x), sizes, self.pool.map)

    def _restless(self, x: np.ndarray) -> Bundle:
        """Simulations about x for the directions in which runs differ."""
        values, given = self.scales.values(x), self.model.plant.parameters
        steps = {
            name: FIRST_STEP * abs(values.get(name, given[name])) or size
            for name, size in self.plan.nuisance.items()
        }
        return self.model.bundle(values, steps, self.pool.map)

    def _made(
        self,
        x: np.ndarray,
        late: np.ndarray,
        noise: np.ndarray,
        steps: np.ndarray,
        bundle: Bundle,
        restless: Bundle | None,
    ) -> Found:
        views, model = self.model.views, self.model
        columns = scaled_columns(model, bundle, self.scales, late)
        moved = [
            [size * each for each in model.slopes(restless, name, late)]
            for name, size in self.plan.nuisance.items()
            if restless is not None
        ]
        if self.plan.start_time:
            delays = model.delays(bundle.base, late)
            moved.append([self.plan.start_time * each for each in delays])
        per_run = [
            np.hypot(noise[view.part], JERK * jerk)
            for view, jerk in zip(views, model.jerks(bundle.base), strict=True)
        ]
        directions = [
            np.array([each[run] for each in moved]).reshape(len(moved), views[run].measured.size)
            for run in range(len(views))
        ]
        whitenings = [Whitening.of(n, d) for n, d in zip(per_run, directions, strict=True)]
        seen = model.seen(bundle.base, late)
        misses = [
            missed(s, view.measured, n) for s, view, n in zip(seen, views, per_run, strict=True)
        ]
        return Found(
            model, self.plan, self.scales, x, late, noise, whitenings, misses, columns, steps,
            bundle, restless, x,
        )  # fmt: skip

    def _remaining(self, state: Found) -> np.ndarray:
        """Noise by channel and feature: what remains beyond what runs do, or the least believed."""
        rests = [w.rest(m) for w, m in zip(state.whitenings, state.misses, strict=True)]
        level = self.plan.model_error * self.rms
        for number, name in enumerate(self.model.views[0].names):
            pieces = [
                rest[view.part == number]
                for rest, view in zip(rests, self.model.views, strict=True)
            ]
            pieces = [each for each in pieces if each.size]
            if name in self.plan.channels and pieces:
                left = np.concatenate(pieces)
                level[number] = max(level[number], float(np.sqrt(np.mean(left**2))))
            elif pieces:
                level[number] = max(level[number], self.floors[number])
        return np.where(level > 0.0, level, 1.0)


def _sizes(model: Model) -> np.ndarray:
    """RMS of every channel and feature over all runs [its unit], shape (names,).

    Of a channel that follows a command, only how far it is off that: a position that a controller
    holds says little by itself.
    """
    names = model.views[0].names
    follows = {name: each.follows for name, each in expectations(model.plant).items()}
    return np.array([_size(model.views, name, follows.get(name, "")) for name in names])


def _size(views: Sequence[View], name: str, command: str) -> float:
    values = []
    for view in views:
        asked = view.recording[command] if command in view.recording else 0.0
        off = {**view.recording.channels}
        if name in view.channels:
            off[name] = off[name] - asked
        values.append(view.of(off)[view.part == view.names.index(name)])
    whole = np.concatenate(values)
    return float(np.sqrt(np.mean(whole**2))) if whole.size else 0.0


def _unsettled(costs: Sequence[float]) -> str:
    path = " -> ".join(f"{each:.4g}" for each in costs[-3:])
    return (
        f"the fit did not settle (misfit {path}); try fewer parameters, values nearer to the "
        "hand's, narrower bounds, or scan = 256"
    )


def cost(loss: str, left: np.ndarray) -> float:
    """Half the sum of squares of a whitened misfit, bent as scipy's least_squares bends it."""
    z = (left / ROBUST) ** 2
    bent = {
        "linear": lambda: z,
        "soft_l1": lambda: 2.0 * (np.sqrt(1.0 + z) - 1.0),
        "huber": lambda: np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0),
        "cauchy": lambda: np.log1p(z),
    }
    return 0.5 * ROBUST**2 * float(np.sum(bent[loss]()))
