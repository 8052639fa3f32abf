"""Run an experiment: whole grasps in one compiled call, by the method of hannes/rodas."""

import functools
import sys
import time
from dataclasses import dataclass

import numpy as np

from hannes._jit import compiles
from hannes.assemble import Compiled
from hannes.effect import Effect
from hannes.entries import LONGEST as LONGEST
from hannes.entries import RUN as RUN
from hannes.errors import BadInput, nearest
from hannes.experiment import Experiment
from hannes.hand import Hand
from hannes.rodas.step import NOT_FINITE
from hannes.stock import HOLD, Stock, tolerances
from hannes.stock import METHODS as STOCK
from hannes.trajectory import Cost, Outcome, Trajectory

METHODS = ("Rodas", *STOCK)


def simulate(
    hand: Hand,
    experiment: Experiment,
    *,
    method: str = "Rodas",
    rtol: float = 1e-4,
    effects: tuple[Effect, ...] | None = None,
) -> Trajectory:
    """Simulate `experiment` with `hand` and return its Trajectory, completed or not.

    `method` is "Rodas" (hannes/rodas) or one of scipy's; `rtol` the relative tolerance, absolute
    ones follow from each state's declared tolerance. `effects` fixes the set that is compiled in
    (default: those of `hand` that are not off). Raises BadInput for a bad method, tolerance or
    value.
    """
    if method not in METHODS:
        raise BadInput(f'unknown method "{method}"{nearest(method, METHODS)}')
    check_tolerance(rtol)
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled(effects)
    p, rest = posed.vector(experiment.shape, effects), posed.rest(compiled)
    say_when_compiling(compiled, "grasps" if method == "Rodas" else "rates")
    if method != "Rodas":
        return Stock(compiled, p, rest, experiment, method, rtol).run()
    plan = Plan.of(compiled, experiment, rtol)
    clock = time.perf_counter()
    ran = plan.run(p[np.newaxis], rest[np.newaxis])
    cost = plan.cost(ran.counts[0], p, time.perf_counter() - clock)
    reached = int(ran.counts[0, 5])
    return Trajectory(
        experiment,
        plan.times[:reached],
        ran.rows[:reached],
        *ended(ran.counts[0]),
        cost,
        compiled,
        p,
        plan.knots,
        ran.holds[:reached],
    )


def check_tolerance(rtol: float) -> None:
    """Raise BadInput where `rtol` cannot be met."""
    if not 1e-13 < rtol < 1.0:
        raise BadInput(f"rtol = {rtol:g}: expected a value between 1e-13 and 1")


@functools.cache
def say_when_compiling(compiled: Compiled, entry: str) -> None:
    """Tell once on standard error that an entry point is about to be compiled."""
    if compiles() and not compiled.is_warm(entry):
        print("hannes: compiling the model, once (about 10 s)", file=sys.stderr, flush=True)


@dataclass(frozen=True)
class Ran:
    """What a compiled call leaves: see `grasps` in entries.py."""

    rows: np.ndarray
    holds: np.ndarray
    kept: np.ndarray
    counts: np.ndarray


@dataclass(frozen=True, eq=False)
class Plan:
    """What the grasps of one compiled call share: model, reference, times, tolerances."""

    compiled: Compiled
    knots: np.ndarray
    bounds: np.ndarray
    times: np.ndarray
    sampled: bool
    rtol: float
    atol: np.ndarray
    columns: np.ndarray

    @staticmethod
    def of(
        compiled: Compiled, experiment: Experiment, rtol: float, columns: tuple[int, ...] = ()
    ) -> "Plan":
        """Plan `experiment`; `columns` of the outputs, then of the states, are kept."""
        reference = experiment.reference
        inside = {float(t) for t in reference.knots[0] if 0.0 < t < experiment.duration}
        ends = sorted(inside) if reference.kinked else []
        return Plan(
            compiled,
            reference.knots,
            np.array([*ends, float(experiment.duration)]),
            experiment.times,
            experiment.controller == "sampled",
            rtol,
            tolerances(compiled, rtol),
            np.array(columns, np.int64),
        )

    def run(self, vectors: np.ndarray, starts: np.ndarray, stop: np.ndarray | None = None) -> Ran:
        """Run one grasp for each row of `vectors`; `starts` (m, states) are used up."""
        count, times = vectors.shape[0], self.times
        rows = np.empty((times.size, starts.shape[1]))
        holds = np.empty((times.size, HOLD))
        kept = np.empty((count, self.columns.size, times.size))
        counts = np.zeros((count, 6), np.int64)
        with np.errstate(all="ignore"):
            self.compiled.fast.grasps(
                vectors, starts, self.knots, self.bounds, self.periods(vectors), times,
                self.columns, self.rtol, self.atol, np.zeros(1, np.bool_) if stop is None else stop,
                rows, holds, kept, counts,
            )  # fmt: skip
        return Ran(rows, holds, kept, counts)

    def periods(self, vectors: np.ndarray) -> np.ndarray:
        """Period of the sampled controller [s], 0 for the continuous one, shape (m,)."""
        if not self.sampled:
            return np.zeros(vectors.shape[0])
        return np.ascontiguousarray(vectors[:, self.compiled.parameters["controller_period"].start])

    def cost(self, counts: np.ndarray, p: np.ndarray, seconds: float) -> Cost:
        """What a grasp took, by its counts."""
        period = float(self.periods(p[np.newaxis])[0])
        parts = round(float(self.bounds[-1]) / period) if self.sampled else self.bounds.size
        return Cost(int(counts[0]), int(counts[1]), parts, seconds)


def ended(counts: np.ndarray) -> tuple[Outcome, str]:
    """How a grasp ended, and in which words."""
    failure = int(counts[4])
    if failure == 0:
        return Outcome.COMPLETED, "completed"
    from hannes.entries import MOST, TOO_MANY
    from hannes.rodas.solver import MESSAGES

    words = {**MESSAGES, TOO_MANY: f"More than {MOST} steps."}
    return (
        Outcome.NOT_FINITE if failure == NOT_FINITE else Outcome.SOLVER_GAVE_UP,
        words[failure],
    )
