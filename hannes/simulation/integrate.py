"""Through scipy's solve_ivp, from kink to kink: by the method of rodas or scipy's own."""

import functools
import math
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from hannes.control.firmware_memory import MEMORY, READING_AGE
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.compiler.grasp_loop import LONGEST, MOST
from hannes.simulation.experiment.experiment import Experiment
from hannes.simulation.trajectory import Cost, Outcome, Trajectory

METHODS = ("Rodas", "LSODA", "BDF", "Radau", "RK45", "RK23", "DOP853")
IMPLICIT = ("LSODA", "BDF", "Radau")
RUN = 512  # steps that Rodas takes between two returns to scipy: most grasps are one
_ready: set[tuple[Compiled, str]] = set()  # whose machine code this process has at hand


@functools.lru_cache(maxsize=16)
def tolerances(compiled: Compiled, rtol: float) -> np.ndarray:
    """Absolute tolerance of each state, shape (states,): as declared at rtol 1e-4."""
    return compiled.states.tolerances * rtol / 1e-4


class Initial:
    """An initial value problem on its way: state and samples so far."""

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
        self.method, self.rtol, self.atol = method, rtol, tolerances(compiled, rtol)
        self.memory = np.zeros(MEMORY)
        self.state, self.first = rest, rest.copy()
        self.past: list[Callable[[float], np.ndarray]] = []  # by tick, where readings are old
        self.cost, self.message = Cost(), "completed"
        self.outcome = Outcome.COMPLETED
        self.times = experiment.times
        self.rows: list[np.ndarray] = []
        self.memories: list[np.ndarray] = []
        self.filled = 0

    def run(self) -> Trajectory:
        """Integrate to the end, or to where it fails."""
        self._make_ready()
        parts = self._ticks() if self.experiment.controller == "sampled" else self._smooth_parts()
        for start, end, knots in parts:
            if not self._advance(start, end, knots):
                break
        return self._result()

    def _make_ready(self) -> None:
        """Compile, where that is still to be done: it is no part of what the solver takes."""
        knots, moment = self.experiment.reference.knots, 1e-9 * self.experiment.duration
        done = (self.compiled, self.method) in _ready
        if done or not self._sets_out(self._rates(knots), 0.0):
            return
        with (
            suppress(ValueError),
            np.errstate(all="ignore"),
        ):  # a failure is reported by the real run
            self._solve(knots, (0.0, moment), np.array([moment]))
        _ready.add((self.compiled, self.method))

    def _smooth_parts(self) -> Iterator[tuple[float, float, np.ndarray]]:
        """Parts between kinks of the reference; Rodas knows of the kinks itself."""
        reference, duration = self.experiment.reference, self.experiment.duration
        if self.method == "Rodas":
            yield 0.0, duration, reference.knots
        else:
            yield from reference.segments(duration)

    def _ticks(self) -> Iterator[tuple[float, float, np.ndarray]]:
        """Parts from tick to tick of the firmware, its duty held in between."""
        knots, duration = self.experiment.reference.knots, self.experiment.duration
        period = float(self.p[self.compiled.parameters["controller_period"]][0])
        for k in range(int(np.ceil(duration / period - 1e-9))):
            self.compiled.fast.tick(k * period, self._read(k, period), self.p, knots, self.memory)
            yield k * period, min((k + 1) * period, duration), knots

    def _read(self, tick: int, period: float) -> np.ndarray:
        """The state that the firmware reads at a tick."""
        moment = tick * period - self.memory[READING_AGE]
        if not self.past:
            return self.state
        return self.first if moment <= 0.0 else self.past[math.ceil(moment / period) - 1](moment)

    def _advance(self, start: float, end: float, knots: np.ndarray) -> bool:
        """Integrate one smooth part and store its samples; False where it failed."""
        inside = self._samples(end)
        if not self._sets_out(self._rates(knots), start):
            return self._fail(Outcome.NOT_FINITE, f"the rates at {start:g} s are not finite")
        clock = time.perf_counter()
        try:
            with np.errstate(all="ignore"):
                part = self._solve(knots, (start, end), self._asked(inside, start, end))
        except ValueError as error:
            if "infs or NaNs" not in str(error):
                raise
            return self._fail(Outcome.NOT_FINITE, str(error))  # scipy will not factor such
        seconds = time.perf_counter() - clock
        self.cost += Cost(int(part.nfev), int(part.njev), self._parts(), seconds)
        rows = np.asarray(part.y).T.reshape(-1, self.state.size)  # a bare list when empty
        if not math.isfinite(rows.sum()):
            sound = np.isfinite(rows).all(axis=1)
            self._store(rows[: min(int(np.argmin(sound)), inside - self.filled)])
            return self._fail(Outcome.NOT_FINITE, part.message)
        if end == self.experiment.duration:
            inside = self.times.size  # where one is left, it is the end itself
        self._store(rows[: inside - self.filled])
        if not part.success:
            lost = "not finite" in part.message
            return self._fail(Outcome.NOT_FINITE if lost else Outcome.SOLVER_GAVE_UP, part.message)
        self.state = rows[-1].copy()
        self.past += [part.sol] if part.sol else []
        return True

    def _solve(self, knots: np.ndarray, span: tuple[float, float], times: np.ndarray) -> Any:
        from scipy.integrate import solve_ivp

        return solve_ivp(
            self._rates(knots),
            span,
            self.state,
            t_eval=times,
            rtol=self.rtol,
            atol=self.atol,
            dense_output=bool(self.memory[READING_AGE]),
            **self._method(knots),
        )

    def _fail(self, outcome: Outcome, message: str) -> bool:
        self.outcome, self.message = outcome, message
        return False

    def _samples(self, end: float) -> int:
        """Number of samples that lie before `end`."""
        return int(self.times.searchsorted(end * (1.0 - 1e-12), "left"))

    def _asked(self, inside: int, start: float, end: float) -> np.ndarray:
        """Sample times up to `inside`, and the end."""
        if start == 0.0 and self.times[-1] == end:
            return self.times
        return np.append(self.times[self.filled : inside], end).clip(start, end)

    def _store(self, rows: np.ndarray) -> None:
        self.rows.append(rows)
        self.memories.append(np.full((rows.shape[0], MEMORY), self.memory))
        self.filled += rows.shape[0]

    def _rates(self, knots: np.ndarray) -> Callable[[float, np.ndarray], np.ndarray]:
        rates, p, memory = self.compiled.fast.rates, self.p, self.memory
        return lambda t, y: rates(t, y, p, knots, memory)

    def _sets_out(self, rates: Callable[..., np.ndarray], start: float) -> bool:
        """Return whether the rates are finite: else scipy's methods would not advance."""
        return self.method == "Rodas" or bool(np.isfinite(rates(start, self.state)).all())

    def _parts(self) -> int:
        """Number of smooth parts that one call of the solver covers."""
        reference, end = self.experiment.reference, self.experiment.duration
        if self.method != "Rodas" or not reference.kinked:
            return 1
        return 1 + sum(0.0 < time < end for time in set(reference.knots[0].tolist()))

    def _method(self, knots: np.ndarray) -> dict[str, Any]:
        """Method and its options."""
        if self.method == "Rodas":
            return self._rodas(knots)
        if self.method not in IMPLICIT:
            return {"method": self.method}
        jacobian, p, memory = self.compiled.fast.jacobian, self.p, self.memory
        return {"method": self.method, "jac": lambda t, y: jacobian(t, y, p, knots, memory)}

    def _rodas(self, knots: np.ndarray) -> dict[str, Any]:
        from hannes.simulation.rodas.scipy_solver import Rodas

        return {
            "method": Rodas,
            "problem": self.compiled.problem(self.p, knots, self.memory),
            "run": RUN,
            "kinks": knots[0] if self.experiment.reference.kinked else (),
            "max_step": LONGEST,
            "most": MOST,
        }

    def _result(self) -> Trajectory:
        if self.outcome is Outcome.COMPLETED and self.filled < self.times.size:
            self._store(self.state[np.newaxis])
        return Trajectory(
            self.experiment,
            self.times[: self.filled],
            _stacked(self.rows, self.state.size),
            self.outcome,
            self.message,
            self.cost,
            self.compiled,
            self.p,
            self.experiment.reference.knots,
            _stacked(self.memories, MEMORY),
        )


def _stacked(blocks: list[np.ndarray], width: int) -> np.ndarray:
    return blocks[0] if len(blocks) == 1 else np.concatenate([np.zeros((0, width)), *blocks])
