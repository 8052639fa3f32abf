"""Whether something changes from run to run in one direction, which no effect of a catalogue does.

A wire that creeps makes each run differ from the one before. Its mean over runs looks like some
effect or other; in the order of the runs it grows. So each effect's mark is tried a second time as
one that grows by as much with every run, where means of groups and the runs in each speak together.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.score_test import Guess, projected
from hannes.identification.diagnosis.tuning import VERDICT


@dataclass(frozen=True)
class Trend:
    """An effect that would grow from run to run, and by how much that lowers the misfit."""

    effect: str
    delta_chi2: float


def strongest_trend(point: Linearisation, guesses: Sequence[Guess]) -> Trend | None:
    """The best of all; None where no command was repeated often enough to see, in a known order."""
    groups = point.model.groups
    if not any(_ordered(group) for group in groups):
        return None
    found = [Trend(each.effect, _gain(point, row)) for each in guesses for row in each.signature]
    return max(found, key=lambda each: each.delta_chi2, default=None)


def _ordered(group: Group) -> bool:
    return group.count >= VERDICT.fewest_repeats and float(np.ptp(group.numbers)) > 0.0


def _gain(point: Linearisation, signature: np.ndarray) -> float:
    """Of a mark, whitened, (N,), that is as often there as runs came before."""
    groups = point.model.groups
    signatures = np.split(signature, np.cumsum([group.part.size for group in groups])[:-1])
    mean = np.concatenate([m * g.numbers.mean() for m, g in zip(signatures, groups, strict=True)])
    gradient, hessian = (float(each.sum()) for each in projected(point, mean[np.newaxis]))
    inside, stiff = _inside(point, signatures)
    if inside**2 < VERDICT.trend_within * stiff:
        return 0.0
    return (gradient + inside) ** 2 / (hessian + stiff)


def _inside(point: Linearisation, signatures: Sequence[np.ndarray]) -> tuple[float, float]:
    """Pull and curvature that runs under one command add, by their order."""
    groups, gradient, hessian = point.model.groups, 0.0, 0.0
    runs = [_of_runs(point, k, each) for k, each in enumerate(signatures)]
    for group, along, signature in zip(groups, runs, signatures, strict=True):
        order = group.numbers - group.numbers.mean()
        gradient += float(order @ along) / group.count
        hessian += float(order @ order * (signature @ signature)) / group.count
    spread = _spread(groups, runs, signatures)
    return gradient / spread, max(hessian / spread, 1e-30)


def _of_runs(point: Linearisation, number: int, signature: np.ndarray) -> np.ndarray:
    """What runs of a group are off their mean, along a mark, (runs,)."""
    group = point.model.groups[number]
    return point.noise.white(number, group.measured - group.mean) @ signature


def _spread(
    groups: Sequence[Group], runs: Sequence[np.ndarray], signatures: Sequence[np.ndarray]
) -> float:
    """Variance of runs along a mark without their trend, over what is told; at least 1."""
    squares, freedom = VERDICT.assumed_weight, VERDICT.assumed_weight
    for group, along, signature in zip(groups, runs, signatures, strict=True):
        if _ordered(group) and (size := float(signature @ signature)) > 0.0:
            order = group.numbers - group.numbers.mean()
            rest = along - order * (order @ along) / (order @ order)
            squares += float(rest @ rest) / size / group.count
            freedom += group.count - 2
    return max(1.0, squares / freedom)
