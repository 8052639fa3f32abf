"""Minimises chi-squared over the active parameters: Gauss-Newton with few simulations a step."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT


def fitted(point: Linearisation, steps: int, restarts: int = 0) -> Linearisation:
    """The fit after `steps` steps, and as many after each of `restarts` new sets of derivatives.

    A step differences the effects' parameters only, which are few, and updates the other
    derivatives by Broyden's rule.
    """
    point = _walked(point, steps)
    for _ in range(restarts):
        point = _walked(relinearised(point), steps)
    return point


def settled(
    point: Linearisation,
    negligible: float = FIT.settled,
    below: float = np.inf,
    above: float = FIT.settled_above,
) -> Linearisation:
    """The fit converged: new derivatives and some steps until the reduction is below `negligible`.

    Gives up where a round reduces chi-squared by less than it still lies above `below`. Where more
    is left than `above` per bin, a round that reduces little of it is the last. One that has
    converged so far is kept. Of many bins noise alone changes chi-squared by more: less is asked.
    """
    negligible = max(negligible, FIT.settled_per_bin * point.residual.size)
    if point.last_reduction < _enough(point, negligible, above):
        return point
    return [point, *rounds(point, negligible, below, above)][-1]


def rounds(
    point: Linearisation,
    negligible: float = FIT.converged,
    below: float = np.inf,
    above: float = FIT.settled_finally,
) -> Iterator[Linearisation]:
    """The fit after each round of new derivatives and some steps, until it is settled."""
    for _ in range(FIT.rounds):
        found = _walked(relinearised(point), FIT.steps_per_round)
        reduction = point.chi2 - found.chi2
        point = replace(found, last_reduction=reduction)
        yield point
        if reduction < max(_enough(point, negligible, above), point.chi2 - below):
            break


def _enough(point: Linearisation, negligible: float, above: float) -> float:
    """Reduction of a round that is the last: where much is left, what is missing decides there."""
    much = FIT.settled_share * (point.chi2 - above * point.residual.size)
    return max(negligible, much)


def relinearised(point: Linearisation) -> Linearisation:
    """The same point with new derivatives by all parameters that the recordings inform about."""
    informed = np.sum(point.jacobian**2, axis=1) > FIT.least_information**2 * point.prior**2
    informed |= point.active >= point.space.uncertain.size
    return point.moved(point.x, point.active[informed]) or point


def _walked(point: Linearisation, steps: int) -> Linearisation:
    for _ in range(steps):
        found = _stepped(point)
        if found is None or found.chi2 >= point.chi2:  # points simulated as changes are approximate
            break
        reduction, point = point.chi2 - found.chi2, found.corrected(point)
        if reduction < FIT.converged:
            break
    return point


def _stepped(point: Linearisation) -> Linearisation | None:
    """A step that reduces chi-squared: the whole one or the best of several; None if none does.

    The whole one counts where it achieves about what it predicts.
    """
    step = newton_step(point)
    place, chi2 = _best(point, [step])
    if chi2 > point.chi2 - FIT.kept_reduction * _predicted(point, step):
        steps = [share * newton_step(point, damping) for damping, share in FIT.shorter_steps]
        place, chi2 = min(((place, chi2), _best(point, steps)), key=lambda each: each[1])
    if chi2 >= point.chi2:
        return None
    return point.moved(place, point.active[point.active >= point.space.uncertain.size])


def _best(point: Linearisation, steps: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """Where the best of these steps leads, within bounds, and chi-squared there."""
    space = point.space
    places = np.repeat(point.x[np.newaxis], len(steps), axis=0)
    places[:, point.active] += steps
    places = np.clip(places, space.low, space.high)
    values = point.chi2_at(places)
    best = int(np.argmin(values))
    return places[best], float(values[best])


def _predicted(point: Linearisation, step: np.ndarray) -> float:
    """Predicted reduction of chi-squared by a step."""
    return float(2.0 * step @ point.gradient - step @ point.hessian @ step)


def newton_step(point: Linearisation, damping: float = 0.0) -> np.ndarray:
    """Step to the least chi-squared within bounds, were it quadratic, (active,).

    Clipped only afterwards, a step of two sizes with nearly the same signature leads uphill.
    damping: times the prior's weight that holds the step back (Levenberg 1944): with contacts
    chi-squared bends within a standard deviation.
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


def wald(point: Linearisation, places: Sequence[int]) -> float:
    """Rise of chi-squared with some parameters at zero, all else following, were it quadratic."""
    chosen = np.flatnonzero(np.isin(point.active, places))
    if not chosen.size:
        return 0.0
    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    x = point.x[point.active[chosen]]
    return float(x @ np.linalg.solve(inverse[np.ix_(chosen, chosen)], x))


def standard_deviations(point: Linearisation) -> np.ndarray:
    """Standard deviations of the active parameters, were chi-squared quadratic, (active,)."""
    hessian = point.hessian + FIT.jitter * np.eye(point.active.size)
    return np.sqrt(np.diag(np.linalg.inv(hessian)))
