"""Simulations of every group at many places of the space at once, as vectors."""

from collections.abc import Sequence

import numpy as np

from hannes.diagnosis.groups import Channels, Group
from hannes.diagnosis.space import Space
from hannes.effect import Effect
from hannes.errors import ComputationFailed
from hannes.plant import Plant

NOWHERE = "the base cannot be simulated under a recording's reference; try a base nearer to it"
SHIFT = 0.4e-3  # s, over which the effect of starting later is differenced
AROUND = 0.1  # standard deviations over which the grain is averaged
SAMPLES = 8  # simulations that the grain is averaged over


class Model:
    """A plant, all runs it shall explain, and the effects on trial.

    Simulations are quick ones: what the firmware's sampling and rounding add (`grain`) is computed
    apart and changes little. `small` is the model without effects, `whole` the one with all that
    are on trial in it, so that one compilation serves them all.
    """

    def __init__(
        self, plant: Plant, groups: Sequence[Group], space: Space, effects: Sequence[Effect]
    ) -> None:
        self.groups, self.space = list(groups), space
        self.small, self.whole = plant, plant.with_effects(*effects)

    def simulated(
        self, group: Group, rows: np.ndarray, effects: bool, exact: bool = False
    ) -> list[Channels | None]:
        """Channels of a group for rows of x, shape (m, size); None where a run breaks down."""
        plant = self.whole if effects else self.small
        columns = self.space.columns(group, rows, effects)
        many = getattr(plant, "many", None)
        if many is not None:
            return list(many(columns, group.recording, group.names, exact))
        return [
            _alone(plant, {name: float(column[k]) for name, column in columns.items()}, group)
            for k in range(len(rows))
        ]

    def vectors(
        self, group: Group, rows: np.ndarray, effects: bool, exact: bool = False
    ) -> np.ndarray:
        """Bin means for rows of x, shape (m, n); nan where a run breaks down."""
        found = np.full((len(rows), group.part.size), np.nan)
        for row, channels in zip(found, self.simulated(group, rows, effects, exact), strict=True):
            if channels is not None:
                row[:] = group.vector(channels)
        return found

    def grain(self, x: np.ndarray, effects: bool, seed: int) -> tuple[list[np.ndarray], ...]:
        """What the firmware's grain adds to each group near x, and how unsure that is.

        Its rounding makes a pattern that the least change moves: what is left in the mean over
        small changes is the part that a model can know, and the variance of that mean is noise
        that all repeats share. Returns means and variances, shape (n,) each.
        """
        rows = x + np.zeros((SAMPLES, x.size))
        known = self.space.uncertain
        drawn = np.random.default_rng([seed, 7]).standard_normal((SAMPLES, known.size))
        rows[:, known] += AROUND * drawn
        means, variances = [], []
        for group in self.groups:
            pair = (self.vectors(group, rows, effects, exact) for exact in (True, False))
            difference = np.subtract(*pair)
            difference = difference[np.isfinite(difference).all(axis=1)]
            if len(difference) < 2:
                raise ComputationFailed(NOWHERE)
            means.append(difference.mean(axis=0))
            variances.append(difference.var(axis=0, ddof=1) / len(difference))
        return means, variances


def _alone(plant: Plant, values: dict[str, float], group: Group) -> Channels | None:
    try:
        return plant.simulate(values, group.recording)
    except ComputationFailed:
        return None
