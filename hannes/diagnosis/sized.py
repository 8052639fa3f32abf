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
from hannes.diagnosis.profile import held_at, profile
from hannes.diagnosis.screen import amplitude_names
from hannes.errors import ComputationFailed

FINER = 2  # times
SURVEYS = 2  # of noise: it moves with the machine


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
    space = fine.ground.model.space
    names = [name for each in effects for name in amplitude_names(space.effects[each])]
    places = [place for place in map(space.place, names) if place in spread]
    told = {place: profile(fine, place, spread[place]) for place in places}
    floor = held_at(fine, np.array(places), np.array([told[each][0] for each in places]))
    return Sized(floor or fine, spread | {place: told[place][1] for place in places})


def _finer(point: Point, effects: Sequence[str], care: Care, seed: int) -> Point:
    model = point.ground.model
    groups = [Group(model.small, each.entries, FINER) for each in model.groups]
    held = model.held(groups)
    for _ in range(SURVEYS):
        try:
            there = begun(held.ticking(point.x, effects), point.x, point.active, care, seed)
        except ComputationFailed:
            break
        point = settled(fitted(there, 4))
    return point
