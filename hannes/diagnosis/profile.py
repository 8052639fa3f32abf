"""How the misfit grows along one parameter, all else following: where it is least, and how surely.

Where fingers touch the misfit has kinks within a standard deviation. Slopes at one place tell then
neither where the floor of a valley is nor how wide it is, and a fit ends in any of its hollows. So
it is walked along both ways until it has risen (Venzon & Moolgavkar 1988), and a parabola told by
all of that.
"""

from collections.abc import Iterator

import numpy as np

from hannes.diagnosis.fit import fitted, settled
from hannes.diagnosis.point import Point

STEP, LONGER = 1.5, 1.5  # standard deviations by slopes; times the step before
MOST = 5  # steps each way
RISEN = 6.0  # above the least misfit met: far enough
OTHER = 16.0  # above it: another valley
HOLLOWS = 3.0  # of the misfit, by which fits end higher or lower by chance
LEAST = 3  # places that tell a parabola


def profile(point: Point, place: int, deviation: float) -> tuple[float, float]:
    """Where the misfit is least along one direction, and its standard deviation there, in steps.

    deviation: the same by the slopes at the point; both are told of it where no valley is found.
    """
    walked = [_walk(point, place, side * STEP * deviation) for side in (-1.0, 1.0)]
    met = np.array([(point.x[place], point.misfit), *(each for way in walked for each in way)])
    away, above = (met[:, 0] - point.x[place]) / deviation, met[:, 1] - met[:, 1].min()
    near = above < OTHER
    if near.sum() < LEAST:
        return float(point.x[place]), deviation
    weights = 1.0 / (HOLLOWS + above[near])
    bend, slope, _ = np.polyfit(away[near], above[near], 2, w=weights)
    if bend <= 0.0:
        return float(point.x[place]), deviation
    space = point.ground.model.space
    least = float(point.x[place]) - deviation * slope / (2.0 * bend)
    return float(np.clip(least, space.low[place], space.high[place])), deviation / bend**0.5


def held_at(point: Point, places: np.ndarray, values: np.ndarray) -> Point | None:
    """The fit with some directions held at values of x; None where that cannot be simulated."""
    x = point.x.copy()
    x[places] = values
    there = point.with_active(np.setdiff1d(point.active, places)).moved(x, np.array([], int))
    return None if there is None else settled(fitted(there, 4))


def _walk(point: Point, place: int, step: float) -> Iterator[tuple[float, float]]:
    """Values of one direction, further and further off, and the misfit where all else follows."""
    space, here, lowest = point.ground.model.space, point, point.misfit
    for _ in range(MOST):
        value = float(here.x[place]) + step
        if not space.low[place] <= value <= space.high[place]:
            return
        there = held_at(here, np.array([place]), np.array([value]))
        if there is None:
            return
        yield value, there.misfit
        here, lowest, step = there, min(lowest, there.misfit), LONGER * step
        if there.misfit > lowest + RISEN:
            return
