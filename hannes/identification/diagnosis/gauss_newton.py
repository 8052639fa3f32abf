"""Finds the least misfit over the active directions: Gauss and Newton, few simulations a step."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT


def fitted(point: Linearisation, steps: int, anew: int = 0) -> Linearisation:
    """The point of the least misfit found in `steps` steps, and in as many after each `anew`.

    Steps take slopes along effects anew, as few as there are, and mend the others by what the
    step did; before each round of `anew` all are had anew.
    """
    point = _walked(point, steps)
    for _ in range(anew):
        point = _walked(relinearised(point), steps)
    return point


def settled(
    point: Linearisation, little: float = FIT.converged, below: float = np.inf
) -> Linearisation:
    """All slopes anew and some steps, until that gains less than `little`; a few times at most.

    Gives up where a round gains less than the misfit still lies above `below`.
    """
    for _ in range(FIT.rounds):
        found = _walked(relinearised(point), FIT.steps_per_round)
        gained, point = point.chi2 - found.chi2, found
        if gained < max(little, point.chi2 - below):
            break
    return point


def relinearised(point: Linearisation) -> Linearisation:
    """The same point with all slopes had anew along which the recordings tell anything."""
    informed = np.sum(point.jacobian**2, axis=1) > FIT.least_information**2 * point.prior**2
    informed |= point.active >= point.space.uncertain.size
    return point.moved(point.x, point.active[informed]) or point


def _walked(point: Linearisation, steps: int) -> Linearisation:
    for _ in range(steps):
        found = _stepped(point)
        if found is None or found.chi2 >= point.chi2:  # many places are had as changes, nearly
            break
        gained, point = point.chi2 - found.chi2, found.corrected(point)
        if gained < FIT.converged:
            break
    return point


def _stepped(point: Linearisation) -> Linearisation | None:
    """A step that lowers the misfit: the whole one, or the best of many; None where there is none.

    The whole one where it does about what it promised.
    """
    step = newton_step(point)
    place, chi2 = _best(point, [step])
    if chi2 > point.chi2 - FIT.kept_reduction * _promised(point, step):
        steps = [
            share * newton_step(point, each) for each in FIT.dampings for share in FIT.step_shares
        ]
        place, chi2 = min(((place, chi2), _best(point, steps)), key=lambda each: each[1])
    if chi2 >= point.chi2:
        return None
    return point.moved(place, point.active[point.active >= point.space.uncertain.size])


def _best(point: Linearisation, steps: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """Where the best of these steps leads, within bounds, and the misfit there."""
    space = point.space
    places = np.repeat(point.x[np.newaxis], len(steps), axis=0)
    places[:, point.active] += steps
    places = np.clip(places, space.low, space.high)
    values = point.chi2_at(places)
    best = int(np.argmin(values))
    return places[best], float(values[best])


def _promised(point: Linearisation, step: np.ndarray) -> float:
    """How much a step lowers the misfit where that is quadratic."""
    return float(2.0 * step @ point.gradient - step @ point.hessian @ step)


def newton_step(point: Linearisation, damping: float = 0.0) -> np.ndarray:
    """Step to the least misfit within bounds were it quadratic, (active,).

    Cut off at bounds only afterwards, a step of two sizes that do nearly the same leads uphill.
    damping: times what is known already, by which a step is held back (Levenberg 1944): where
    fingers touch the misfit bends within a standard deviation.
    """
    from scipy.optimize import lsq_linear

    space, x = point.space, point.x[point.active]
    low, high = space.low[point.active] - x, space.high[point.active] - x
    hessian = point.hessian + np.diag(damping * point.prior**2 + FIT.jitter)
    step = np.linalg.solve(hessian, point.gradient)
    if ((low <= step) & (step <= high)).all():
        return step
    root = np.linalg.cholesky(hessian)
    return np.clip(
        lsq_linear(root.T, np.linalg.solve(root, point.gradient), (low, high), "bvls").x, low, high
    )


def standard_deviations(point: Linearisation) -> np.ndarray:
    """Standard deviations of the active directions were the misfit quadratic, (active,)."""
    hessian = point.hessian + FIT.jitter * np.eye(point.active.size)
    return np.sqrt(np.diag(np.linalg.inv(hessian)))
