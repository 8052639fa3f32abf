"""What an effect gains on runs that were not fitted, without another simulation.

About the points that were found the misfit is nearly quadratic: fitted to some of the runs alone
they move a little, and what they then leave on the other runs follows from the slopes.
"""

from collections.abc import Sequence

import numpy as np

from hannes.diagnosis.groups import Group
from hannes.diagnosis.point import Point


def held_out(base: Point, trial: Point, seen: Sequence[int], unseen: Sequence[int]) -> float:
    """Misfit of the base less that of the trial on the runs that were not fitted.

    `seen`, `unseen`: bit masks of the runs of each group. Zero where there are none.
    """
    return _left(base, seen, unseen) - _left(trial, seen, unseen)


def _left(point: Point, seen: Sequence[int], unseen: Sequence[int]) -> float:
    space = point.ground.model.space
    pulls, curvature = np.zeros(point.active.size), np.diag(point.prior**2).astype(float)
    pulls -= point.prior**2 * point.x[point.active]
    for number, (group, mask) in enumerate(zip(point.ground.model.groups, seen, strict=True)):
        if not (count := bin(mask).count("1")):
            continue
        miss, columns = _part(point, number, group, mask, count)
        pulls += columns @ miss
        curvature += columns @ columns.T
    step = np.linalg.solve(curvature + 1e-9 * np.eye(point.active.size), pulls)
    low, high = (each[point.active] for each in (space.low, space.high))
    step = np.clip(point.x[point.active] + step, low, high) - point.x[point.active]
    total = 0.0
    for number, (group, mask) in enumerate(zip(point.ground.model.groups, unseen, strict=True)):
        if count := bin(mask).count("1"):
            miss, columns = _part(point, number, group, mask, count)
            left = miss - step @ columns
            total += float(left @ left)
    return total


def _part(
    point: Point, number: int, group: Group, mask: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Whitened miss and slopes of some runs of a group: the mean of fewer runs is noisier."""
    ground = point.ground
    runs = [k for k in range(group.count) if mask >> k & 1]
    miss = group.measured[runs].mean(axis=0) - point.vectors[number] - ground.grain[number]
    weight = np.sqrt(count / group.count)
    return (
        weight * ground.white(number, miss),
        weight * ground.white(number, point.slopes[number]),
    )
