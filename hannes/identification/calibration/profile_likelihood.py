"""Asymmetric half-widths by profile, where the cost is no parabola.

A profile moves one parameter and lets the others follow. An interval ends where the cost has grown
by as much as a parabola would at the half-width by run.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from hannes.identification.calibration.intervals import Spread
from hannes.identification.calibration.least_squares import cost
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.objective import Problem
from hannes.identification.calibration.tuning import CALIBRATION


def sides(found: State, spread: Spread, workers: int) -> np.ndarray:
    """Half-widths below and above every parameter, scaled, shape (2, p)."""
    profile = _Profile(found, spread)
    tasks = [(k, side) for side in (-1.0, 1.0) for k in range(len(found.plan.names))]
    with ThreadPoolExecutor(workers) as pool:
        reach = list(pool.map(lambda task: profile.reach(*task), tasks))
    return np.array(reach).reshape(2, -1)


class _Profile:
    """Cost along one parameter while the others follow."""

    def __init__(self, found: State, spread: Spread) -> None:
        self.found, self.problem, self.spread = found, Problem(found), spread
        self.jacobian = np.vstack([found.jacobian().T, np.diag(found.scales.prior)])
        self.loss = found.plan.loss
        self.least_cost = cost(self.loss, self.problem.residual(found.x))

    def reach(self, place: int, side: float) -> float:
        """Half-width on one side (-1 below, 1 above), scaled."""
        expected = float(self.spread.reach[place])
        variance, scales = float(self.spread.covariance[place, place]), self.found.scales
        value = abs(float(self.found.x[place] + scales.nominal[place] / scales.scale[place]))
        if place in self.found.on_bound or not 0.0 < expected < max(1.0, value):
            return expected
        aim = 0.5 * expected**2 / variance
        led = cost(self.loss, self.problem.residual(self._led(place, side * expected)))
        if abs((led - self.least_cost) / aim - 1.0) < CALIBRATION.not_parabolic:
            return expected
        tried: list[tuple[float, float]] = [(0.0, 0.0)]
        at = expected
        for _ in range(CALIBRATION.profile_trials):
            tried.append((at, self._growth(place, side * at)))
            at = min(_crossing(tried, aim), CALIBRATION.widest_profile * expected)
        return at

    def _led(self, place: int, step: float) -> np.ndarray:
        """The point with one parameter moved and the others where the linearisation leads them."""
        covariance, scales = self.spread.covariance, self.found.scales
        x = self.found.x + step * covariance[:, place] / covariance[place, place]
        return np.clip(x, scales.low, scales.high)

    def _growth(self, place: int, step: float) -> float:
        """Growth of the cost with one parameter moved and the others fitted by one more step."""
        scales, x = self.found.scales, self._led(place, step)
        left = self.problem.residual(x)
        if not np.isfinite(left).all():
            return np.inf
        others = np.arange(x.size) != place
        jacobian = self.jacobian[:, others]
        if others.any():
            x[others] -= np.linalg.lstsq(jacobian, left, rcond=None)[0]
        x = np.clip(x, scales.low, scales.high)
        followed = self.problem.residual(x)
        return min(cost(self.loss, left), cost(self.loss, followed)) - self.least_cost


def _crossing(tried: Sequence[tuple[float, float]], aim: float) -> float:
    """Where the root of the growth reaches that of `aim`, by the two nearest trials."""
    roots = sorted((at, np.sqrt(max(growth, 0.0))) for at, growth in tried if np.isfinite(growth))
    goal = np.sqrt(aim)
    above = [each for each in roots if each[1] >= goal]
    below = [each for each in roots if each[1] < goal]
    if not above:
        at, root = below[-1]
        return at * min(goal / max(root, 1e-3 * goal), 2.0)
    low, high = below[-1], above[0]
    return low[0] + (high[0] - low[0]) * (goal - low[1]) / (high[1] - low[1])
