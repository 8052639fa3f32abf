"""What an effect gains on runs that were not fitted: base and effect refitted without them."""

from collections.abc import Sequence

import numpy as np

from hannes.identification.diagnosis.gauss_newton import fitted
from hannes.identification.diagnosis.linearisation import Ground, Point, grounded

STEPS = 3  # of a fit from where all runs have led, which is near


def held_out(base: Point, trial: Point, seen: Sequence[int], unseen: Sequence[int]) -> float:
    """Misfit of the base less that of the trial on the runs that were not fitted.

    `seen`, `unseen`: bit masks of the runs of each group. Zero where either has none.
    """
    if not (any(seen) and any(unseen)):
        return 0.0
    return _left(base, seen, unseen) - _left(trial, seen, unseen)


def _left(point: Point, seen: Sequence[int], unseen: Sequence[int]) -> float:
    found = fitted(_only(point, seen), STEPS)
    there = _only(point, unseen).moved(found.x, np.zeros(0, int))
    return float("inf") if there is None else float(there.miss @ there.miss)


def _only(point: Point, masks: Sequence[int]) -> Point:
    """The point as some of the runs alone would have it: means of fewer runs are noisier."""
    ground, numbers = point.ground, [k for k, mask in enumerate(masks) if mask]
    whole = [ground.model.groups[k] for k in numbers]
    groups = [
        group.only([n for n in range(group.count) if masks[k] >> n & 1])
        for k, group in zip(numbers, whole, strict=True)
    ]
    covariances = [
        ground.covariances[k] * (old.count / new.count)
        for k, old, new in zip(numbers, whole, groups, strict=True)
    ]
    grain = [ground.grain[k] for k in numbers]
    model, rows = ground.model.of(groups, numbers), [ground.restless[k] for k in numbers]
    some = Ground(model, ground.noise, grain, covariances, rows, ground.told)
    vectors, slopes = ([each[k] for k in numbers] for each in (point.vectors, point.slopes))
    return grounded(point, some, vectors, slopes)
