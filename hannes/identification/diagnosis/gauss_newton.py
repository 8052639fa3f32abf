"""Finds the least misfit over the active directions: Gauss and Newton, few simulations a step."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.linearisation import Point

KEPT = 0.3  # of what a whole step promises, that it must keep
DAMPINGS = (0.0, 0.3, 3.0, 30.0, 300.0)  # of the steps that are tried together where it does not
SHARES = (1.0, 0.35)  # of each
ROUNDS = 5  # of slopes anew, at most, until a fit has settled
STEPS = 5  # with slopes as they are mended, far quicker than slopes anew
SETTLED = 0.3  # of the misfit: a step that gains less is the last
UNTOLD = 0.4  # of what is known already: a parameter of which recordings tell less stays
LIGHT = 1e-6  # lest the curvature has no inverse


def fitted(point: Point, steps: int, anew: int = 0) -> Point:
    """The point of the least misfit found in `steps` steps, and in as many after each `anew`.

    Steps take slopes along effects anew, as few as there are, and mend the others by what the
    step did; before each round of `anew` all are had anew.
    """
    point = _walked(point, steps)
    for _ in range(anew):
        point = _walked(relinearised(point), steps)
    return point


def settled(point: Point, little: float = SETTLED, below: float = np.inf) -> Point:
    """All slopes anew and some steps, until that gains less than `little`; a few times at most.

    Gives up where a round gains less than the misfit still lies above `below`.
    """
    for _ in range(ROUNDS):
        found = _walked(relinearised(point), STEPS)
        gained, point = point.misfit - found.misfit, found
        if gained < max(little, point.misfit - below):
            break
    return point


def relinearised(point: Point) -> Point:
    """The same point with all slopes had anew along which the recordings tell anything."""
    told = np.sum(point.columns**2, axis=1) > UNTOLD**2 * point.prior**2
    told |= point.active >= point.ground.model.space.uncertain.size
    return point.moved(point.x, point.active[told]) or point


def _walked(point: Point, steps: int) -> Point:
    for _ in range(steps):
        found = _stepped(point)
        if found is None or found.misfit >= point.misfit:  # many places are had as changes, nearly
            break
        gained, point = point.misfit - found.misfit, found.corrected(point)
        if gained < SETTLED:
            break
    return point


def _stepped(point: Point) -> Point | None:
    """A step that lowers the misfit: the whole one, or the best of many; None where there is none.

    The whole one where it does about what it promised.
    """
    step = newton_step(point)
    place, misfit = _best(point, [step])
    if misfit > point.misfit - KEPT * _promised(point, step):
        steps = [share * newton_step(point, each) for each in DAMPINGS for share in SHARES]
        place, misfit = min(((place, misfit), _best(point, steps)), key=lambda each: each[1])
    if misfit >= point.misfit:
        return None
    return point.moved(place, point.active[point.active >= point.ground.model.space.uncertain.size])


def _best(point: Point, steps: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """Where the best of these steps leads, within bounds, and the misfit there."""
    space = point.ground.model.space
    places = np.repeat(point.x[np.newaxis], len(steps), axis=0)
    places[:, point.active] += steps
    places = np.clip(places, space.low, space.high)
    misfits = point.misfits(places)
    best = int(np.argmin(misfits))
    return places[best], float(misfits[best])


def _promised(point: Point, step: np.ndarray) -> float:
    """How much a step lowers the misfit where that is quadratic."""
    return float(2.0 * step @ point.pull - step @ point.curvature @ step)


def newton_step(point: Point, damping: float = 0.0) -> np.ndarray:
    """Step to the least misfit within bounds were it quadratic, (active,).

    Cut off at bounds only afterwards, a step of two sizes that do nearly the same leads uphill.
    damping: times what is known already, by which a step is held back (Levenberg 1944): where
    fingers touch the misfit bends within a standard deviation.
    """
    from scipy.optimize import lsq_linear

    space, x = point.ground.model.space, point.x[point.active]
    low, high = space.low[point.active] - x, space.high[point.active] - x
    curvature = point.curvature + np.diag(damping * point.prior**2 + LIGHT)
    step = np.linalg.solve(curvature, point.pull)
    if ((low <= step) & (step <= high)).all():
        return step
    root = np.linalg.cholesky(curvature)
    return np.clip(
        lsq_linear(root.T, np.linalg.solve(root, point.pull), (low, high), "bvls").x, low, high
    )


def deviations(point: Point) -> np.ndarray:
    """Standard deviations of the active directions were the misfit quadratic, (active,)."""
    curvature = point.curvature + LIGHT * np.eye(point.active.size)
    return np.sqrt(np.diag(np.linalg.inv(curvature)))
