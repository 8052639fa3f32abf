"""Finds the least misfit over the active directions: Gauss and Newton, few simulations a step."""

import numpy as np

from hannes.diagnosis.point import Point

SHORTER = 0.35  # of a step that led nowhere
TRIES = 5
SETTLED = 0.3  # of the misfit: a step that gains less is the last
UNTOLD = 0.15  # of what is known already: a parameter of which recordings tell less stays
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


def relinearised(point: Point) -> Point:
    """The same point with all slopes had anew along which the recordings tell anything."""
    told = np.sum(point.columns**2, axis=1) > UNTOLD**2 * point.prior**2
    told |= point.active >= point.ground.model.space.uncertain.size
    return point.moved(point.x, point.active[told]) or point


def _walked(point: Point, steps: int) -> Point:
    for _ in range(steps):
        found = _stepped(point)
        if found is None:
            break
        gained, point = point.misfit - found.misfit, found.corrected(point)
        if gained < SETTLED:
            break
    return point


def _stepped(point: Point) -> Point | None:
    """A step that lowers the misfit, None where there is none."""
    space = point.ground.model.space
    fresh = point.active[point.active >= space.uncertain.size]
    step = newton_step(point)
    for _ in range(TRIES):
        x = point.x.copy()
        x[point.active] = np.clip(
            x[point.active] + step, space.low[point.active], space.high[point.active]
        )
        found = point.moved(x, fresh)
        if found is not None and found.misfit < point.misfit:
            return found
        step = SHORTER * step
    return None


def newton_step(point: Point) -> np.ndarray:
    """Step to the least misfit were it quadratic; directions at a bound stay there, (active,)."""
    space, x = point.ground.model.space, point.x[point.active]
    low, high = space.low[point.active], space.high[point.active]
    step, free = np.zeros(x.size), np.ones(x.size, bool)
    held = (x <= low) & (point.pull < 0.0) | (x >= high) & (point.pull > 0.0)
    free &= ~held
    curvature = point.curvature[np.ix_(free, free)]
    step[free] = np.linalg.solve(curvature + LIGHT * np.eye(free.sum()), point.pull[free])
    return step


def deviations(point: Point) -> np.ndarray:
    """Standard deviations of the active directions were the misfit quadratic, (active,)."""
    curvature = point.curvature + LIGHT * np.eye(point.active.size)
    return np.sqrt(np.diag(np.linalg.inv(curvature)))
