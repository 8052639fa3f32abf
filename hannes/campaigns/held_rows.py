"""Rows in which a logger wrote its last frame again, as opposed to a machine at rest."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.core.recording.white_noise import noise, quantum

FloatArray = NDArray[np.float64]

FEWEST = 3  # repeated samples that are no chance
AROUND = 6  # samples on each side by which a channel is seen to go on
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
    same &= np.any([_goes_on(each, same) for each in moving], axis=0)
    return same if np.count_nonzero(same) >= FEWEST else np.zeros_like(same)


def _goes_on(values: FloatArray, held: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where a channel, by what it is before and after a hold, changes by several of its steps."""
    step = max(quantum(values), 3.0 * noise(values), 1e-4 * float(np.ptp(values)))
    place = np.arange(values.size)
    fresh = np.flatnonzero(~held)
    before = np.searchsorted(fresh, place, side="right") - 1
    ahead = fresh[np.minimum(before + AROUND, fresh.size - 1)]
    behind = fresh[np.maximum(before - AROUND, 0)]
    way = np.stack(
        [
            np.abs(values[ahead] - values[place]) / np.maximum(ahead - place, 1),
            np.abs(values[place] - values[behind]) / np.maximum(place - behind, 1),
        ]
    )
    moved = way.min(axis=0)  # on both sides: a jump is no motion
    return (moved > STEPS * step) & (before + AROUND < fresh.size) & (before >= AROUND)
