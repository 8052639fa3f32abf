"""Whether something changes from run to run in one direction, which no effect of a catalogue does.

A wire that creeps makes each run differ from the one before. Its mean over runs looks like some
effect or other; in the order of the runs it grows. So each effect's mark is tried a second time as
one that grows by as much with every run, where means of groups and the runs in each speak together.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.linearisation import Point
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.score_test import Guess, projected

FEWEST = 3  # runs of a group, to tell drift from scatter
TOLD = 10.0  # runs whose weight the scatter has that is told, against what repeats show
INSIDE = 7.0  # of the gain that runs under one command must show: means may differ for any reason


@dataclass(frozen=True)
class Drift:
    """An effect that would grow from run to run, and by how much that lowers the misfit."""

    effect: str
    gain: float


def drifts(point: Point, guesses: Sequence[Guess]) -> Drift | None:
    """The best of all; None where no command was repeated often enough to see, in a known order."""
    groups = point.ground.model.groups
    if not any(_ordered(group) for group in groups):
        return None
    found = [Drift(each.effect, _gain(point, row)) for each in guesses for row in each.columns]
    return max(found, key=lambda each: each.gain, default=None)


def _ordered(group: Group) -> bool:
    return group.count >= FEWEST and float(np.ptp(group.numbers)) > 0.0


def _gain(point: Point, mark: np.ndarray) -> float:
    """Of a mark, whitened, (N,), that is as often there as runs came before."""
    groups = point.ground.model.groups
    marks = np.split(mark, np.cumsum([group.part.size for group in groups])[:-1])
    mean = np.concatenate([m * g.numbers.mean() for m, g in zip(marks, groups, strict=True)])
    pull, curvature = (float(each.sum()) for each in projected(point, mean[np.newaxis]))
    inside, stiff = _inside(point, marks)
    if inside**2 < INSIDE * stiff:
        return 0.0
    return (pull + inside) ** 2 / (curvature + stiff)


def _inside(point: Point, marks: Sequence[np.ndarray]) -> tuple[float, float]:
    """Pull and curvature that runs under one command add, by their order."""
    groups, pull, curvature = point.ground.model.groups, 0.0, 0.0
    runs = [_of_runs(point, k, each) for k, each in enumerate(marks)]
    for group, along, mark in zip(groups, runs, marks, strict=True):
        order = group.numbers - group.numbers.mean()
        pull += float(order @ along) / group.count
        curvature += float(order @ order * (mark @ mark)) / group.count
    spread = _spread(groups, runs, marks)
    return pull / spread, max(curvature / spread, 1e-30)


def _of_runs(point: Point, number: int, mark: np.ndarray) -> np.ndarray:
    """What runs of a group are off their mean, along a mark, (runs,)."""
    group = point.ground.model.groups[number]
    return point.ground.white(number, group.measured - group.mean) @ mark


def _spread(
    groups: Sequence[Group], runs: Sequence[np.ndarray], marks: Sequence[np.ndarray]
) -> float:
    """Variance of runs along a mark without their trend, over what is told; at least 1."""
    squares, freedom = TOLD, TOLD
    for group, along, mark in zip(groups, runs, marks, strict=True):
        if _ordered(group) and (size := float(mark @ mark)) > 0.0:
            order = group.numbers - group.numbers.mean()
            rest = along - order * (order @ along) / (order @ order)
            squares += float(rest @ rest) / size / group.count
            freedom += group.count - 2
    return max(1.0, squares / freedom)
