"""Tests for structure in the residual, which noise does not have.

Summed over all bins a small effect drowns in noise. A missing effect changes slowly, though, and
appears in some channel of some run. So the slowest components of the residual there are compared
with the quick ones, which only noise has (F test, Bonferroni over all tests).

A fit also absorbs most of what is slow. Little of a missing effect may be left, and still be more
than a machine with free parameters leaves of noise. That is tested at the baseline (score test,
Rao 1948): the slow components of one channel are freed, all else follows as if it had no bounds,
and what they would take of chi-squared has an F distribution: noise is known from some simulations.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.tuning import FIT, NOISE, VERDICT


@dataclass(frozen=True)
class StructuredResidual:
    """What is left of a channel in one run and is autocorrelated.

    where: channel and run, in words
    excess: squared standard deviations beyond what noise leaves: of `autocorrelated` in all
            significant channels, of `channel_excess` in this one
    p_value: that noise alone leaves as much anywhere
    """

    where: str
    excess: float
    p_value: float


def autocorrelated(point: Linearisation) -> StructuredResidual | None:
    """The least probable residual of all; None where chance explains it."""
    squares = [
        (name, each)
        for name, each in _squares(point)
        if each.size > 2 * VERDICT.slow_components[-1]
    ]
    if not squares:
        return None
    usual = float(np.median([np.mean(each[VERDICT.slow_components[-1] :]) for _, each in squares]))
    found = [_least(name, each, usual, _known_from(point)) for name, each in squares]
    excess = sum(each.excess for each in found if each.p_value < VERDICT.residual_p_value)
    least = min(found, key=lambda each: each.p_value)
    p_value = min(1.0, least.p_value * len(found) * len(VERDICT.slow_components))
    return (
        replace(least, excess=excess, p_value=p_value)
        if p_value < VERDICT.residual_p_value
        else None
    )


def channel_excess(point: Linearisation) -> StructuredResidual | None:
    """The least probable residual of a baseline in one channel of one run; None for chance.

    The noise is as assumed, or as the quick components of most channels have it, if that is more:
    an impulsive effect contributes to quick components too. Where noise is known from a few repeats
    alone, it is not known well enough, and nothing is concluded.
    """
    if not point.noise.simulated_noise:
        return None
    squares = [each for _, each in _squares(point) if each.size > 2 * VERDICT.slow_components[-1]]
    if not squares:
        return None
    level = max(
        1.0, float(np.median([np.mean(each[VERDICT.slow_components[-1] :]) for each in squares]))
    )
    found = list(_freed(point, level))
    least = min(found, key=lambda each: (each.p_value, -each.excess))  # chance may underflow to 0
    p_value = min(1.0, least.p_value * len(found))
    return replace(least, p_value=p_value) if p_value < VERDICT.residual_p_value else None


def _freed(point: Linearisation, level: float) -> Iterator[StructuredResidual]:
    """What free slow components of each channel take of chi-squared beyond their number."""
    from scipy.fft import idct
    from scipy.stats import f

    inverse = np.linalg.inv(point.hessian + FIT.jitter * np.eye(point.active.size))
    residual = point.residual - point.gradient @ inverse @ point.jacobian
    for place, name, bins in _channels(point):
        if bins <= 2 * VERDICT.slow_components[-1]:
            continue
        waves = idct(np.eye(bins), norm="ortho", axis=1)
        for count in VERDICT.slow_components:
            left, moved = (
                waves[:count] @ residual[place],
                point.jacobian[:, place] @ waves[:count].T,
            )
            spread = np.eye(count) - moved.T @ inverse @ moved
            taken = float(left @ np.linalg.solve(spread + FIT.jitter * np.eye(count), left))
            p_value = float(f.sf(taken / level / count, count, NOISE.fine_samples - 1))
            yield StructuredResidual(name, taken - count * level, p_value)


def _known_from(point: Linearisation) -> float:
    """How many runs say how slow the noise is, at most: without end where it is simulated.

    Of a few repeats the colour is known no better than they and what is assumed of runs show it.
    """
    if point.noise.simulated_noise:
        return np.inf
    repeats = sum(group.count - 1 for group in point.model.groups)
    return repeats + VERDICT.assumed_weight


def _least(name: str, squares: np.ndarray, usual: float, known_from: float) -> StructuredResidual:
    """The less probable sum of the slowest components of a channel."""
    from scipy.stats import f

    level, found = max(float(np.mean(squares[VERDICT.slow_components[-1] :])), usual), []
    for count in VERDICT.slow_components:
        ratio = float(np.mean(squares[:count])) / level
        quick = min(squares.size - VERDICT.slow_components[-1], known_from)
        p_value = float(f.sf(ratio, count, quick))
        found.append(StructuredResidual(name, (ratio - 1.0) * count * level, p_value))
    return min(found, key=lambda each: each.p_value)


def _squares(point: Linearisation) -> list[tuple[str, np.ndarray]]:
    """Channel and run, and squared components of the residual there, slowest first."""
    from scipy.fft import dct

    return [
        (name, dct(point.residual[place], norm="ortho") ** 2) for place, name, _ in _channels(point)
    ]


def _channels(point: Linearisation) -> Iterator[tuple[slice, str, int]]:
    """Slice of each channel of each group, its name in words, and its bins."""
    start = 0
    for group in point.model.groups:
        for name in group.names:
            where = f"the {name} of runs like {group.entries[0].name}"
            yield slice(start, start + group.bins), where, group.bins
            start += group.bins
