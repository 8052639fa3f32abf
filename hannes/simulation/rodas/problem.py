"""Any right-hand side as a problem for the method: dense Jacobian, plain or compiled.

What a solver asks of a problem: `data`, `advance` and `sample`, see step.py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.kernels.jit import kernel
from hannes.simulation.rodas import source, step
from hannes.simulation.rodas.linear_algebra import copy_to, factor, substitute

Function = Callable[..., Any]
NUDGE = 1.5e-8  # root of the machine's precision: relative step of forward differences


@dataclass(frozen=True)
class Problem:
    """Compiled functions of the method and the data that they pass around."""

    advance: Function
    sample: Function
    data: Any


class Plain:
    """A right-hand side in Python: `fun(t, y)`; `many(t, ys)`, ys (n, k); `jac(t, y)` or None.

    `scale` (n,): sizes of the states below which a difference step does not shrink; `interval`:
    times between which it is asked for. It is given copies of the states, its own to keep.
    """

    def __init__(
        self,
        fun: Function,
        many: Function,
        jac: Function | None,
        scale: np.ndarray,
        interval: tuple[float, float],
    ) -> None:
        n = scale.size
        self.fun, self.many, self.jac = fun, many, jac
        self.scale, self.interval = scale, interval
        self.matrix, self.factors = np.zeros((n, n)), np.zeros((n, n))
        self.rows, self.data, self.sample = np.zeros(n, np.int64), (), step.sample_pieces

    def slope(self, t: float, y: np.ndarray, dy: np.ndarray, data: Any) -> None:
        """Fill dy with f(t, y)."""
        dy[:] = self.fun(t, y.copy())

    def linearise(
        self, t: float, y: np.ndarray, rates: np.ndarray, drift: np.ndarray, data: Any
    ) -> None:
        """Keep df/dy, fill drift with df/dt."""
        near = self._near(t)
        drift[:] = (self.many(near, y[:, np.newaxis].copy())[:, 0] - rates) / (near - t)
        if self.jac is not None:
            self.matrix[:] = self.jac(t, y.copy())
            return
        nudges = y + NUDGE * np.maximum(np.abs(y), self.scale) - y
        moved = self.many(t, y[:, np.newaxis] + np.diag(nudges))
        self.matrix[:] = (moved - rates[:, np.newaxis]) / nudges

    def _near(self, t: float) -> float:
        """Another time inside the interval: later, or earlier at its end."""
        start, end = self.interval
        nudge = max(NUDGE * abs(end - start), 64.0 * float(np.spacing(abs(t))))
        nudge = float(np.copysign(nudge, end - start))
        return t + nudge if abs(t + nudge - start) <= abs(end - start) else t - nudge

    def decompose(self, shift: float, data: Any) -> None:
        """Factor shift I - df/dy."""
        factor(self.matrix, shift, self.factors, self.rows)

    def resolve(self, b: np.ndarray, data: Any) -> None:
        """Replace b by the solution of the factored system."""
        substitute(self.factors, self.rows, b)

    def mark(self, y: np.ndarray, data: Any) -> None:
        """Kinks of f are not known."""

    def crossing(self, y: np.ndarray, data: Any) -> float:
        """None is known."""
        return 2.0

    def advance(self, *arguments: Any) -> int:
        """See step.advance."""
        with np.errstate(all="ignore"):  # a value that is not finite ends the run
            return step.advance(self, *arguments)


def compiled(fun: Any, scale: np.ndarray, direction: float = 1.0) -> Problem:
    """Compile the method together with `fun(t, y) -> array`, itself compiled; takes seconds."""

    @kernel
    def slope(t, y, dy, data):
        copy_to(dy, fun(t, y))

    @kernel
    def linearise(t, y, rates, drift, data):
        matrix, _, _, scale, direction = data
        later = t + direction * NUDGE * max(abs(t), 1e-3)
        drift[:] = (fun(later, y) - rates) / (later - t)
        moved = y.copy()
        for j in range(y.size):
            moved[j] = y[j] + NUDGE * max(abs(y[j]), scale[j])
            matrix[:, j] = (fun(t, moved) - rates) / (moved[j] - y[j])
            moved[j] = y[j]

    @kernel
    def decompose(shift, data):
        matrix, factors, rows, _, _ = data
        factor(matrix, shift, factors, rows)

    @kernel
    def resolve(b, data):
        _, factors, rows, _, _ = data
        substitute(factors, rows, b)

    @kernel
    def mark(y, data):
        pass

    @kernel
    def crossing(y, data):
        return 2.0

    functions = {"mark": mark, "crossing": crossing, "slope": slope, "linearise": linearise}
    space = source.compiled({**functions, "decompose": decompose, "resolve": resolve})
    n = scale.size
    data = (np.zeros((n, n)), np.zeros((n, n)), np.zeros(n, np.int64), scale, direction)
    return Problem(space["advance"], space["sample_pieces"], data)
