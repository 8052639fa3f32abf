"""One bounded least-squares search by scipy, ended where the data cannot resolve more."""

from dataclasses import dataclass

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.calibration.objective import Problem, Settled
from hannes.identification.calibration.tuning import CALIBRATION

NOTHING_SIMULATES = (
    "no simulation succeeds at the starting values; try base = a hand.toml that runs, narrower "
    "bounds, or fewer parameters"
)


@dataclass(frozen=True)
class Solved:
    """Where a search ended: scaled x, cost, indices of parameters at a bound."""

    x: np.ndarray
    cost: float
    on_bound: np.ndarray
    settled: bool


def solve(problem: Problem, x: np.ndarray, tolerance: float = CALIBRATION.fine_tolerance) -> Solved:
    """Search from x; ComputationFailed where nothing can be simulated there."""
    from scipy.optimize import least_squares

    loss, scales = problem.state.plan.loss, problem.state.scales
    inside = np.clip(x, scales.low + 1e-9, scales.high - 1e-9)
    if not np.isfinite(problem.residual(inside)).all():
        raise ComputationFailed(NOTHING_SIMULATES)
    try:
        found = least_squares(
            problem.residual,
            inside,
            jac=problem.jacobian,
            bounds=(scales.low, scales.high),
            loss=loss,
            f_scale=CALIBRATION.robust_scale,
            ftol=tolerance,
            xtol=CALIBRATION.fine_tolerance,
            gtol=None,
            max_nfev=CALIBRATION.max_evaluations,
        )
        at, settled = found.x, found.status > 0
    except Settled:
        at, settled = problem.last[0], True
    left = problem.residual(at)
    on_bound = np.flatnonzero(
        (at - scales.low < CALIBRATION.at_bound) | (scales.high - at < CALIBRATION.at_bound)
    )
    return Solved(at, cost(loss, left), on_bound, settled)


def cost(loss: str, left: np.ndarray) -> float:
    """Half the sum of squares of a whitened residual, with scipy's robust loss."""
    z = (left / CALIBRATION.robust_scale) ** 2
    losses = {
        "linear": lambda: z,
        "soft_l1": lambda: 2.0 * (np.sqrt(1.0 + z) - 1.0),
        "huber": lambda: np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0),
        "cauchy": lambda: np.log1p(z),
    }
    return 0.5 * CALIBRATION.robust_scale**2 * float(np.sum(losses[loss]()))


def weights(loss: str, left: np.ndarray) -> np.ndarray:
    """Weight that a robust loss gives every element, shape (n,)."""
    z = (left / CALIBRATION.robust_scale) ** 2
    if loss == "soft_l1":
        return 1.0 / np.sqrt(1.0 + z)
    if loss == "huber":
        return 1.0 / np.sqrt(np.maximum(z, 1.0))
    return 1.0 / (1.0 + z) if loss == "cauchy" else np.ones_like(z)
