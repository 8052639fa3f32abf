"""Rows in which a logger wrote its last frame again, as opposed to a machine at rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.core.recording.white_noise import noise, quantum

FloatArray = NDArray[np.float64]

FEWEST = 3  # repeated samples that are no chance
AROUND = 6  # samples on each side by which a channel is seen to go on
SELDOM = 0.3  # share of repeats, below which a channel is noisy enough to count
CHANCE = 1e-3  # runs of repeats that are expected by chance, below which one is none
STEPS = 2.0  # of a channel's steps a sample: it cannot repeat itself


def held_rows(channels: Sequence[FloatArray]) -> NDArray[np.bool_]:
    """Whether each row repeats all of several measured channels though it should not, (n,).

    A machine at rest, or at its turn, repeats itself rightly: a repeat counts where the channels
    around it go on by several of their steps. What a channel has is thus never taken for a doubled
    row at rest.
    """
    moving = [each for each in channels if np.nanmax(each) > np.nanmin(each)]
    same = np.zeros(channels[0].size if channels else 0, np.bool_)
    if len(moving) < 2:
        return same
    same[1:] = np.all([np.diff(each) == 0.0 for each in moving], axis=0)
    if not same.any():
        return same
    same &= np.any([_goes_on(each, same) for each in moving], axis=0) | _unlikely(moving, same)
    return same if np.count_nonzero(same) >= FEWEST else np.zeros_like(same)


def _unlikely(channels: Sequence[FloatArray], same: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Runs of repeats longer than the noise of the channels would leave by chance."""
    fresh = ~same[1:]
    if np.count_nonzero(fresh) < FEWEST:
        return np.zeros_like(same)
    by_chance = 1.0
    for each in channels:
        share = max(float(np.mean(np.diff(each)[fresh] == 0.0)), 1.0 / same.size)
        if share < SELDOM and noise(each[~same]) > 0.0:
            by_chance *= share
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(np.int8), [0]))))
    found = np.zeros_like(same)
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        found[first:end] = by_chance ** (end - first) * same.size < CHANCE
    return found


def _goes_on(values: FloatArray, held: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where a channel, by what it is before and after a hold, changes by several of its steps."""
    step = max(quantum(values), 3.0 * noise(values), 1e-4 * float(np.ptp(values)))
    place = np.arange(values.size)
    fresh = np.flatnonzero(~held)
    before = np.searchsorted(fresh, place, side="right") - 1
    ahead = fresh[np.minimum(before + AROUND, fresh.size - 1)]
    behind = fresh[np.maximum(before - AROUND, 0)]
    moved = np.abs(values[ahead] - values[behind]) / np.maximum(ahead - behind, 1)
    return (moved > STEPS * step) & (before + AROUND < fresh.size) & (before >= AROUND)
