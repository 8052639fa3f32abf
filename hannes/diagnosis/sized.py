"""The fit of what was named gone on to its end: how large it is, and how surely.

To tell effects apart many fits are compared, in bins that quick simulations of any machine bear and
about noise as it is without any effect. Once a name is found there is one machine left: what
its firmware adds can be had with the effect in it, and finer bins bear more of what was recorded.
Nothing is chosen by that.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.diagnosis.fit import deviations, fitted, settled
from hannes.diagnosis.groups import Group
from hannes.diagnosis.point import Care, Point, begun
from hannes.diagnosis.profile import HOLLOWS, held_at, profile
from hannes.errors import ComputationFailed

FINER = 2  # times


@dataclass(frozen=True)
class Sized:
    """A fit, and the standard deviation of each active direction, by place, in steps."""

    point: Point
    deviations: dict[int, float]


def sized(point: Point, effects: Sequence[str], care: Care, seed: int) -> Sized:
    """The fit in finer bins, where these can be simulated, at the floor of its valley."""
    fine = _finer(point, effects, care, seed)
    spread = dict(zip(fine.active.tolist(), deviations(fine).tolist(), strict=True))
    if fine is point:
        return Sized(point, spread)
    places = np.intersect1d(fine.ground.model.space.of(*effects), fine.active)
    told = {int(place): profile(fine, int(place), spread[place]) for place in places}
    floor = held_at(fine, places, np.array([least for least, _ in told.values()]))
    if floor is None or floor.misfit > fine.misfit + HOLLOWS * places.size:
        floor = fine  # least along each, but not along all together
    return Sized(floor, spread | {place: wide for place, (_, wide) in told.items()})


def _finer(point: Point, effects: Sequence[str], care: Care, seed: int) -> Point:
    model = point.ground.model
    held = model.held([Group(model.small, each.entries, FINER) for each in model.groups])
    try:
        there = begun(held.ticking(point.x, effects), point.x, point.active, care, seed)
    except ComputationFailed:
        return point
    return settled(fitted(there, 4))
