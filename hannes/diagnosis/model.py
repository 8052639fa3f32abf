"""Simulations of every group at many places of the space at once, as vectors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hannes.diagnosis.groups import Channels, Group, roughness
from hannes.diagnosis.space import Space
from hannes.effect import Effect
from hannes.errors import ComputationFailed
from hannes.plant import Plant

NOWHERE = "the base cannot be simulated under a recording's reference; try a base nearer to it"
SHIFT = 0.4e-3  # s, over which the effect of starting later is differenced
AROUND = 0.1  # standard deviations over which the grain is averaged


@dataclass(frozen=True)
class Grain:
    """What firmware adds to a group's run.

    mean: shape (n,), the part that a model can know; strays: shape (samples, n), what each run was
    off that mean, as any run may be: friction holds on to it for as long as the machine turns one
    way; rough: of each channel's samples, see `roughness`
    """

    mean: np.ndarray
    strays: np.ndarray
    rough: dict[str, float]


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

    def grain(self, x: np.ndarray, samples: int, seed: int) -> "list[Grain]":
        """What the firmware's grain adds to each group near x, and how it differs from run to run.

        Its rounding makes a pattern that the least change moves, and its sensors' noise, where the
        plant knows of it (`noisy`), moves the machine.
        """
        rows = x + np.zeros((samples, x.size))
        known = self.space.uncertain
        drawn = np.random.default_rng([seed, 7]).standard_normal((samples, known.size))
        rows[:, known] += AROUND * drawn
        return [self._grain(group, rows) for group in self.groups]

    def _grain(self, group: Group, rows: np.ndarray) -> "Grain":
        runs = [each for each in self._firmware(group, rows) if each is not None]
        smooth = self.vectors(group, rows, False)
        if len(runs) < max(2, len(rows)) or not np.isfinite(smooth).all():
            raise ComputationFailed(NOWHERE)
        difference = np.array([group.vector(each) for each in runs]) - smooth
        mean = difference.mean(axis=0)
        rough = [{name: roughness(each[name]) for name in group.names} for each in runs]
        usual = {name: float(np.median([each[name] for each in rough])) for name in group.names}
        strays = (difference - mean) * np.sqrt(len(runs) / (len(runs) - 1.0))
        return Grain(mean, strays, usual)

    def _firmware(self, group: Group, rows: np.ndarray) -> list[Channels | None]:
        """Channels by the firmware, which reads noisy sensors where the plant knows of them."""
        noisy = getattr(self.small, "noisy", None)
        if noisy is None:
            return self.simulated(group, rows, False, exact=True)
        columns = self.space.columns(group, rows, False) | noisy(group.recording, len(rows))
        return list(self.small.many(columns, group.recording, group.names, True))  # type: ignore[attr-defined]


def _alone(plant: Plant, values: dict[str, float], group: Group) -> Channels | None:
    try:
        return plant.simulate(values, group.recording)
    except ComputationFailed:
        return None
