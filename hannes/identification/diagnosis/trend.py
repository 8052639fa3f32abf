"""Whether something changes from run to run in one direction, as no effect of the catalogue does.

A wire that creeps makes each run differ from the one before. Averaged over runs it resembles some
effect or other; in the order of the runs it grows. So each effect's signature is tested a second
time, growing by the same amount with every run. Group means and the order within groups both
count.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.repeat_groups import Group, one_by_one
from hannes.identification.diagnosis.score_test import Guess, projected
from hannes.identification.diagnosis.tuning import VERDICT


@dataclass(frozen=True)
class Trend:
    """An effect that would grow from run to run, and its chi-squared reduction."""

    effect: str
    delta_chi2: float


def strongest_trend(point: Linearisation, guesses: Sequence[Guess]) -> Trend | None:
    """The trend with the largest reduction; None where no repeats in a known order show any."""
    groups = point.model.groups
    if not any(ordered(group) for group in groups):
        return None
    apart = [_apart(point, group) for group in groups]
    found = [
        Trend(each.effect, _reduction(point, row, apart))
        for each in guesses
        for row in each.signature
    ]
    return max(found, key=lambda each: each.delta_chi2, default=None)


def ordered(group: Group) -> bool:
    """Whether a group has repeats enough, in a known order."""
    return group.count >= VERDICT.fewest_repeats and float(np.ptp(group.numbers)) > 0.0


def _apart(point: Linearisation, group: Group) -> np.ndarray:
    """Deviations of a group's runs from their mean, less what effects that act by run explain."""
    apart = group.measured - group.mean
    if not point.x[point.space.by_run].any():
        return apart
    # Of copies: corrections for sampling belong to the group alone.
    runs = one_by_one([group])
    made = np.array([point.model.vectors(each, point.x[np.newaxis], True)[0] for each in runs])
    return apart - (made - made.mean(axis=0))


def _reduction(point: Linearisation, signature: np.ndarray, apart: Sequence[np.ndarray]) -> float:
    """Reduction of a signature, whitened, (N,), times the number of runs before each."""
    groups = point.model.groups
    signatures = np.split(signature, np.cumsum([group.part.size for group in groups])[:-1])
    mean = np.concatenate([m * g.numbers.mean() for m, g in zip(signatures, groups, strict=True)])
    gradient, hessian = (float(each.sum()) for each in projected(point, mean[np.newaxis]))
    inside, stiff = _inside(point, signatures, apart)
    if inside**2 < VERDICT.trend_within * stiff:
        return 0.0
    return (gradient + inside) ** 2 / (hessian + stiff)


def _inside(
    point: Linearisation, signatures: Sequence[np.ndarray], apart: Sequence[np.ndarray]
) -> tuple[float, float]:
    """Gradient and Hessian that the order of runs under one command adds."""
    groups, gradient, hessian = point.model.groups, 0.0, 0.0
    pairs = zip(apart, signatures, strict=True)
    runs = [point.noise.white(k, rows) @ each for k, (rows, each) in enumerate(pairs)]
    for group, along, signature in zip(groups, runs, signatures, strict=True):
        order = group.numbers - group.numbers.mean()
        gradient += float(order @ along) / group.count
        hessian += float(order @ order * (signature @ signature)) / group.count
    spread = _spread(groups, runs, signatures)
    return gradient / spread, max(hessian / spread, 1e-30)


def _spread(
    groups: Sequence[Group], runs: Sequence[np.ndarray], signatures: Sequence[np.ndarray]
) -> float:
    """Variance of runs along a signature without their trend, over what is assumed; at least 1."""
    squares, freedom = VERDICT.assumed_weight, VERDICT.assumed_weight
    for group, along, signature in zip(groups, runs, signatures, strict=True):
        if ordered(group) and (size := float(signature @ signature)) > 0.0:
            order = group.numbers - group.numbers.mean()
            rest = along - order * (order @ along) / (order @ order)
            squares += float(rest @ rest) / size / group.count
            freedom += group.count - 2
    return max(1.0, squares / freedom)
