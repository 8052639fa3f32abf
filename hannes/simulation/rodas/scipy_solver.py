"""Rodas as a method of scipy: `solve_ivp(fun, span, y0, method=Rodas)`."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from hannes.simulation.rodas.problem import Plain
from hannes.simulation.rodas.step import NOT_FINITE, TOO_MANY, TOO_SMALL, WORK

LEAST = 100.0 * np.finfo(float).eps  # relative tolerance that is not refused
MESSAGES = {
    TOO_SMALL: "Required step size is less than spacing between numbers.",
    NOT_FINITE: "The right-hand side is not finite.",
    TOO_MANY: "More steps than allowed.",
}


class Rodas(OdeSolver):
    """Linearly implicit for stiff problems: Rodas4P2, order 4; from `rtol` 2e-3 on Rodas3, order 3.

    Arguments as for scipy's own implicit solvers, but that `rtol` is one number for all states;
    `jac` a function, a constant matrix (dense or sparse) or None for forward differences. Raises
    ValueError for what cannot be used. Four arguments are its own:

    problem : object or None
        The right-hand side compiled together with the method (see problem.py); `fun` and `jac`
        are then not called.
    run : int
        How many steps one `step` may take. Its dense output spans them all, so `t_eval` and
        `dense_output` lose nothing by a long run; events are looked for between its ends, so
        leave it at 1 where there are any.
    kinks : array_like, shape (k,)
        Times at which the right-hand side has a kink or a jump: no step leads across one.
    most : int
        How many steps it may take in all; beyond them it fails.
    """

    def __init__(
        self,
        fun: Callable[..., Any],
        t0: float,
        y0: np.ndarray,
        t_bound: float,
        max_step: float = np.inf,
        rtol: float = 1e-3,
        atol: float | np.ndarray = 1e-6,
        jac: Any = None,
        vectorized: bool = False,
        first_step: float | None = None,
        problem: Any = None,
        run: int = 1,
        kinks: Any = (),
        most: float = np.inf,
        **extraneous: Any,
    ) -> None:
        if extraneous:
            names = ", ".join(extraneous)
            warnings.warn(f"Rodas has no argument {names}: not used", stacklevel=3)
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self.y = np.array(y0, float)  # steps move it in place
        self.rtol, self.atol = _tolerances(rtol, atol, self.n)
        if not max_step > 0.0:
            raise ValueError("`max_step` must be positive.")
        if run < 1:
            raise ValueError("`run` must be at least 1.")
        self.run, self.most, self._counted = int(run), most, problem is not None
        if problem is not None:  # scipy's wrappers hold their solver, and it all of its output,
            self.fun = self.fun_vectorized = self.fun_single  # until garbage is collected
        self.problem = problem or self._plain(jac)
        if not (first_step is None or 0.0 < first_step <= abs(t_bound - t0)):
            raise ValueError("`first_step` must be positive and within the interval.")
        self._bounds = _bounds(kinks, float(t0), float(t_bound))
        first = 0.0 if first_step is None else self.direction * first_step
        self.clock = np.array([t0, first, self._bounds[0], max_step, 1.0, 0.0])
        self.counts = np.zeros(5, np.int64)
        self.work = np.zeros((WORK, self.n))

    def _plain(self, jac: Any) -> Plain:
        scale = np.maximum(self.atol / self.rtol, 1e-12)
        dense = _jacobian(jac, self.n)
        interval = float(self.t), float(self.t_bound)
        return Plain(self.fun, self.fun_vectorized, dense, scale, interval)

    def _step_impl(self) -> tuple[bool, str | None]:
        if self.counts[1] >= self.most:
            return False, MESSAGES[TOO_MANY]
        ends, pieces = np.empty(self.run + 1), np.empty((self.run + 1, 3, self.n))
        self.y = self.y.copy()
        taken = self.problem.advance(
            *(self.problem.data, self.y, self.rtol, self.atol, self.clock, self.counts),
            *(self._bounds, ends, pieces, self.work),
        )
        if self._counted:
            self.nfev = int(self.counts[0])
        self.njev, self.nlu = int(self.counts[1]), int(self.counts[2])
        if taken == 0:
            return False, MESSAGES[int(self.counts[4])]
        self.t = float(self.clock[0])
        self._ends, self._pieces = ends[: taken + 1], pieces
        return True, None

    def _dense_output_impl(self) -> "Pieces":
        return Pieces(self.problem.sample, self._ends, self._pieces)


class Pieces(DenseOutput):
    """Dense output over a run of steps."""

    def __init__(self, sample: Callable[..., Any], ends: np.ndarray, pieces: np.ndarray) -> None:
        super().__init__(ends[0], ends[-1])
        self._sample, self._ends, self._pieces = sample, ends, pieces

    def _call_impl(self, t: np.ndarray) -> np.ndarray:
        times = np.atleast_1d(np.asarray(t, float))
        rows = np.empty((times.size, self._pieces.shape[2]))
        self._sample(times, self._ends, self._pieces, rows)
        return rows[0] if np.ndim(t) == 0 else rows.T


def _bounds(kinks: Any, start: float, end: float) -> np.ndarray:
    """Ends of the smooth parts of the way."""
    low, high = min(start, end), max(start, end)
    inside = {t for t in np.asarray(kinks, float).ravel().tolist() if low < t < high}
    return np.array([*sorted(inside, reverse=start > end), end])


def _tolerances(rtol: float, atol: Any, n: int) -> tuple[float, np.ndarray]:
    """Check as scipy does; the absolute one as (n,)."""
    if np.ndim(rtol):
        raise ValueError("Rodas takes one `rtol`; give `atol` per state.")
    if rtol < LEAST:
        warnings.warn(f"At least one element of `rtol` is too small, set to {LEAST}.", stacklevel=4)
    atol = np.asarray(atol, float)
    if atol.ndim > 0 and atol.shape != (n,):
        raise ValueError("`atol` has wrong shape.")
    if (atol < 0.0).any():
        raise ValueError("`atol` must be positive.")
    return max(float(rtol), LEAST), atol.copy() if atol.ndim > 0 else np.full(n, atol)


def _jacobian(jac: Any, n: int) -> Callable[..., Any] | None:
    """`jac` as a function of t and y that returns a dense matrix (n, n), or None."""
    if jac is None:
        return None

    def dense(matrix: Any) -> np.ndarray:
        found = np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, float)
        if found.shape != (n, n):
            raise ValueError(f"`jac` is expected to have shape {(n, n)}, but has {found.shape}.")
        return found

    if callable(jac):
        return lambda t, y: dense(jac(t, y))
    constant = dense(jac)
    return lambda t, y: constant
