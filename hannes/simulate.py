"""Run an experiment: scipy's solve_ivp over the compiled rates, restarted at every kink."""

import functools
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from hannes._jit import compiles
from hannes.assemble import Compiled
from hannes.effect import Effect
from hannes.errors import BadInput, nearest
from hannes.experiment import Experiment
from hannes.hand import Hand
from hannes.trajectory import Cost, Outcome, Trajectory

METHODS = ("Rodas", "LSODA", "BDF", "Radau", "RK45", "RK23", "DOP853")
RUN = 256  # steps that Rodas takes between two returns to Python
LONGEST = 0.1  # s, of its steps: a longer one may not see a contact that comes and goes
IMPLICIT = ("LSODA", "BDF", "Radau")
HOLD = 7


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
    if not 1e-13 < rtol < 1.0:
        raise BadInput(f"rtol = {rtol:g}: expected a value between 1e-13 and 1")
    posed = hand.with_values(experiment.overrides())
    compiled = posed.compiled(effects)
    _say_when_compiling(compiled, "advance" if method == "Rodas" else "rates")
    packed = posed.vector(experiment.shape, effects)
    run = _Run(compiled, packed, posed.rest(compiled), experiment, method, rtol)
    return run.sampled() if experiment.controller == "sampled" else run.continuous()


@functools.cache
def _say_when_compiling(compiled: Compiled, entry: str) -> None:
    if compiles() and not compiled.is_warm(entry):
        print("hannes: compiling the model, once (about 10 s)", file=sys.stderr, flush=True)


class _Run:
    """One simulation in progress: state and samples so far."""

    def __init__(
        self,
        compiled: Compiled,
        p: np.ndarray,
        rest: np.ndarray,
        experiment: Experiment,
        method: str,
        rtol: float,
    ) -> None:
        self.compiled, self.p, self.experiment = compiled, p, experiment
        self.method, self.rtol = method, rtol
        self.hold = np.zeros(HOLD)
        self.state = rest
        self.cost, self.message = Cost(), "completed"
        self.outcome = Outcome.COMPLETED
        tolerances = [s.tolerance for s in compiled.states.slots for _ in range(s.size)]
        self.atol = np.array(tolerances) * rtol / 1e-4
        self.times = experiment.times
        self.rows: list[np.ndarray] = []
        self.holds: list[np.ndarray] = []
        self.filled = 0

    def continuous(self) -> Trajectory:
        """Integrate from kink to kink; Rodas knows them itself."""
        if self.method == "Rodas":
            self._advance(0.0, self.experiment.duration, self.experiment.reference.knots)
            return self._result()
        for start, end, knots in self.experiment.reference.segments(self.experiment.duration):
            if not self._advance(start, end, knots):
                break
        return self._result()

    def sampled(self) -> Trajectory:
        """Integrate from tick to tick of the firmware, its duty held in between."""
        knots, period = self.experiment.reference.knots, self._period()
        if self.method == "Rodas":
            return self._firmware(knots, period)
        ticks = int(np.ceil(self.experiment.duration / period - 1e-9))
        for k in range(ticks):
            start, end = k * period, min((k + 1) * period, self.experiment.duration)
            self.compiled.fast.tick(start, self.state, self.p, knots, self.hold)
            if not self._advance(start, end, knots):
                break
        return self._result()

    def _firmware(self, knots: np.ndarray, period: float) -> Trajectory:
        """The same in one compiled call."""
        from hannes.rodas.solver import MESSAGES
        from hannes.rodas.step import NOT_FINITE, WORK

        times, n = self.times, self.state.size
        rows, holds = np.zeros((times.size, n)), np.zeros((times.size, HOLD))
        counts, work = np.zeros(5, np.int64), np.zeros((WORK, n))
        problem, clock = self.compiled.problem(self.p, knots, self.hold), time.perf_counter()
        span = (period, self.experiment.duration)
        filled = self.compiled.fast.firmware(
            problem.data, self.state, self.rtol, self.atol, *span, counts, work, times, rows, holds
        )
        seconds = time.perf_counter() - clock
        self.cost += Cost(int(counts[0]), int(counts[1]), round(span[1] / span[0]), seconds)
        sound = np.isfinite(rows[:filled]).all(axis=1)
        self.filled = filled if sound.all() else int(np.argmin(sound))
        self.rows, self.holds = [rows[: self.filled]], [holds[: self.filled]]
        if counts[4] != 0:
            outcome = Outcome.NOT_FINITE if counts[4] == NOT_FINITE else Outcome.SOLVER_GAVE_UP
            self._fail(outcome, MESSAGES[int(counts[4])])
        return self._result()

    def _period(self) -> float:
        return float(self.p[self.compiled.parameters["controller_period"]][0])

    def _advance(self, start: float, end: float, knots: np.ndarray) -> bool:
        """Integrate one smooth part and store its samples; False where it failed."""
        from scipy.integrate import solve_ivp

        rates, inside = self._rates(knots), self._samples(end)
        if not self._sets_out(rates, start):
            return self._fail(Outcome.NOT_FINITE, f"the rates at {start:g} s are not finite")
        clock = time.perf_counter()
        try:
            with np.errstate(all="ignore"):
                part = solve_ivp(
                    rates,
                    (start, end),
                    self.state,
                    t_eval=np.clip(np.append(self.times[self.filled : inside], end), start, end),
                    rtol=self.rtol,
                    atol=self.atol,
                    **self._method(knots),
                )
        except ValueError as error:
            if "infs or NaNs" not in str(error):
                raise
            return self._fail(Outcome.NOT_FINITE, str(error))  # scipy will not factor such
        self.cost += Cost(part.nfev, part.njev, self._parts(), time.perf_counter() - clock)
        rows = np.asarray(part.y).T.reshape(-1, self.state.size)  # a bare list when empty
        if not np.isfinite(rows.sum()):
            sound = np.isfinite(rows).all(axis=1)
            self._store(rows[: min(int(np.argmin(sound)), inside - self.filled)])
            return self._fail(Outcome.NOT_FINITE, part.message)
        self._store(rows[: inside - self.filled])
        if not part.success:
            lost = "not finite" in part.message
            return self._fail(Outcome.NOT_FINITE if lost else Outcome.SOLVER_GAVE_UP, part.message)
        self.state = rows[-1].copy()
        return True

    def _parts(self) -> int:
        """Number of smooth parts that one call of the solver covers."""
        if self.method != "Rodas" or self.experiment.controller == "sampled":
            return 1
        return len(self.experiment.reference.segments(self.experiment.duration))

    def _fail(self, outcome: Outcome, message: str) -> bool:
        self.outcome, self.message = outcome, message
        return False

    def _samples(self, end: float) -> int:
        """Number of samples that lie before `end`."""
        return int(np.searchsorted(self.times, end * (1.0 - 1e-12), "left"))

    def _store(self, rows: np.ndarray) -> None:
        self.rows.append(rows)
        self.holds.append(np.tile(self.hold, (rows.shape[0], 1)))
        self.filled += rows.shape[0]

    def _rates(self, knots: np.ndarray) -> Callable[[float, np.ndarray], np.ndarray]:
        rates, p, hold = self.compiled.fast.rates, self.p, self.hold
        return lambda t, y: rates(t, y, p, knots, hold)

    def _sets_out(self, rates: Callable[..., np.ndarray], start: float) -> bool:
        """Tell whether the rates are finite; scipy's methods would step on the spot."""
        return self.method == "Rodas" or bool(np.isfinite(rates(start, self.state)).all())

    def _method(self, knots: np.ndarray) -> dict[str, Any]:
        """Method and its options."""
        if self.method != "Rodas":
            return {"method": self.method, **self._jacobian(knots)}
        from hannes.rodas.solver import Rodas

        problem = self.compiled.problem(self.p, knots, self.hold)
        reference = self.experiment.reference
        kinks = reference.knots[0] if reference.kinked else ()
        return {
            "method": Rodas,
            "problem": problem,
            "run": RUN,
            "kinks": kinks,
            "max_step": LONGEST,
        }

    def _jacobian(self, knots: np.ndarray) -> dict[str, Any]:
        if self.method not in IMPLICIT:
            return {}
        jacobian, p, hold = self.compiled.fast.jacobian, self.p, self.hold
        return {"jac": lambda t, y: jacobian(t, y, p, knots, hold)}

    def _result(self) -> Trajectory:
        if self.outcome is Outcome.COMPLETED and self.filled < self.times.size:
            self._store(self.state[np.newaxis])
        return Trajectory(
            self.experiment,
            self.times[: self.filled],
            self.rows[0] if len(self.rows) == 1 else _stacked(self.rows, self.state.size),
            self.outcome,
            self.message,
            self.cost,
            self.compiled,
            self.p,
            self.experiment.reference.knots,
            _stacked(self.holds, HOLD),
        )


def _stacked(blocks: list[np.ndarray], width: int) -> np.ndarray:
    return np.concatenate([np.zeros((0, width)), *blocks])
