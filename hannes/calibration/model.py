"""Simulates all runs of a calibration at given values, and differences them by parameters.

Repeats of one command share a simulation. Where a plant also has `smooth`, a quick simulation
without the grain of its firmware, slopes come from that, and what it leaves out (`simulate` minus
`smooth`) is computed once for a whole search.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from hannes.calibration.view import View
from hannes.errors import ComputationFailed
from hannes.plant import Plant

Channels = dict[str, np.ndarray]
Map = Callable[[Callable[..., Any], Iterable[Any]], Iterable[Any]]
SHIFT = 1e-3  # s, over which the effect of starting later is differenced


class Model:
    """A plant and the runs that it shall explain."""

    def __init__(self, plant: Plant, views: Sequence[View]) -> None:
        self.plant, self.views = plant, list(views)
        groups: dict[bytes, list[int]] = {}
        for place, view in enumerate(views):
            groups.setdefault(plant.same_run(view.recording), []).append(place)
        self.groups = list(groups.values())
        self.smooth = getattr(plant, "smooth", plant.simulate)
        self.grain: list[Channels] = [{} for _ in self.groups]

    def settle(self, values: Mapping[str, float], spread_over: Map = map) -> None:
        """Compute anew what the quick simulation leaves out, at `values`."""
        if self.smooth == self.plant.simulate:
            return

        def grain(group: Sequence[int]) -> Channels:
            recording = self.views[group[0]].recording
            exact = self.plant.simulate(values, recording)
            quick = self.smooth(values, recording)
            return {name: exact[name] - quick[name] for name in exact}

        self.grain = list(spread_over(grain, self.groups))

    def channels(self, values: Mapping[str, float], number: int) -> Channels:
        """Simulated channels of one group of repeats; ComputationFailed where it breaks down."""
        quick = self.smooth(values, self.views[self.groups[number][0]].recording)
        grain = self.grain[number]
        return {name: each + grain[name] for name, each in quick.items()} if grain else quick

    def vectors(
        self, values: Mapping[str, float], late: np.ndarray, spread_over: Map = map
    ) -> list[np.ndarray]:
        """Simulated vector of every run; `late` [s] is when each one starts, shape (runs,)."""
        done = list(
            spread_over(lambda number: self.channels(values, number), range(len(self.groups)))
        )
        return self._seen(done, late)

    def _seen(self, done: Sequence[Channels], late: np.ndarray) -> list[np.ndarray]:
        found: list[np.ndarray] = [np.zeros(0)] * len(self.views)
        for channels, group in zip(done, self.groups, strict=True):
            for place in group:
                found[place] = self.views[place].of(channels, float(late[place]))
        return found

    def delays(self, values: Mapping[str, float], late: np.ndarray) -> list[np.ndarray]:
        """Change of every run's vector per second that it starts later."""
        done = [self.channels(values, number) for number in range(len(self.groups))]
        before, after = (self._seen(done, late + side * SHIFT) for side in (-0.5, 0.5))
        return [(b - a) / SHIFT for a, b in zip(before, after, strict=True)]

    def columns(
        self,
        values: Mapping[str, float],
        late: np.ndarray,
        steps: Mapping[str, float],
        spread_over: Map = map,
    ) -> list[np.ndarray]:
        """Slopes of every run's vector by the parameters in `steps` [SI], shape (names, n) each.

        A step that leads out of a parameter's bounds, or into a failed simulation, is taken the
        other way; where both fail the column is zero.
        """
        base = self.vectors(values, late, spread_over)
        made = spread_over(lambda name: self._column(values, late, base, name, steps[name]), steps)
        columns = list(made)
        return [np.array([each[run] for each in columns]) for run in range(len(self.views))]

    def _column(
        self,
        values: Mapping[str, float],
        late: np.ndarray,
        base: Sequence[np.ndarray],
        name: str,
        step: float,
    ) -> list[np.ndarray]:
        low, high = self.plant.parameters.declared[name].bounds
        at = values.get(name, self.plant.parameters[name])
        for side in (step, -step):
            if not low <= at + side <= high:
                continue
            try:
                moved = self.vectors({**values, name: at + side}, late)
            except ComputationFailed:
                continue
            slopes = [(m - b) / side for m, b in zip(moved, base, strict=True)]
            return [np.nan_to_num(each, nan=0.0) for each in slopes]
        return [np.zeros_like(each) for each in base]
