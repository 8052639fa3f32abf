"""Simulates all runs of a calibration at given values, and differences them by parameters.

Repeats of one command share a simulation. A plant may also have `smooth`, a quick simulation
without the controller's discretisation. Then derivatives come from that, and the difference
(`simulate` minus `smooth`) is computed once for a whole search.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.identification.binned_run import View
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.plants.protocol import Plant

Channels = dict[str, np.ndarray]
PART_STEP = 0.01  # relative deviation of a part, of differences
Map = Callable[[Callable[..., Any], Iterable[Any]], Iterable[Any]]


@dataclass(frozen=True)
class Bundle:
    """Simulations about one point: channels of each group of repeats, at the point and moved.

    `moved` has, for each parameter, the channels of each group (None where no step succeeded) and
    the step [SI].
    """

    centre: list[Channels]
    moved: dict[str, tuple[list[Channels] | None, float]]


class Model:
    """A plant and the runs that it is fitted to."""

    def __init__(self, plant: Plant, views: Sequence[View]) -> None:
        self.plant, self.views = plant, list(views)
        groups: dict[bytes, list[int]] = {}
        for place, view in enumerate(views):
            groups.setdefault(plant.same_run(view.recording), []).append(place)
        self.groups = list(groups.values())
        self._smooth = getattr(plant, "smooth", None)
        self.discretisation: list[Channels] = [{} for _ in self.groups]

    def settle(
        self, values: Mapping[str, float], quick: Sequence[Channels], spread_over: Map = map
    ) -> None:
        """Compute the discretisation error anew; `quick` is the quick simulation at `values`."""
        if self._smooth is None:
            return

        def discretisation(number: int) -> Channels:
            exact = self.plant.simulate(values, self.views[self.groups[number][0]].recording)
            return {name: exact[name] - quick[number][name] for name in exact}

        self.discretisation = list(spread_over(discretisation, range(len(self.groups))))

    def run(self, values: Mapping[str, float], spread_over: Map = map) -> list[Channels]:
        """Quick simulation of every group of repeats; ComputationFailed where one fails."""
        simulate = self._smooth or self.plant.simulate
        recordings = [self.views[group[0]].recording for group in self.groups]
        return list(spread_over(lambda recording: simulate(values, recording), recordings))

    def vectors(self, done: Sequence[Channels], start_offsets: np.ndarray) -> list[np.ndarray]:
        """Vector of every run, discretisation included; start_offsets [s]: shape (runs,)."""
        found: list[np.ndarray] = [np.zeros(0)] * len(self.views)
        for channels, discretisation, group in zip(
            done, self.discretisation, self.groups, strict=True
        ):
            whole = (
                {n: each + discretisation[n] for n, each in channels.items()}
                if discretisation
                else channels
            )
            for place in group:
                found[place] = self.views[place].of(whole, float(start_offsets[place]))
        return found

    def nonlinearities(self, done: Sequence[Channels]) -> list[np.ndarray]:
        """Within-bin nonlinearity of every run's vector, see View.nonlinearities."""
        pairs = zip(done, self.groups, strict=True)
        placed = {
            place: self.views[place].nonlinearities(each)
            for each, group in pairs
            for place in group
        }
        return [placed[place] for place in range(len(self.views))]

    def delays(self, done: Sequence[Channels], start_offsets: np.ndarray) -> list[np.ndarray]:
        """Change of every run's vector per second of later start."""
        before, after = (
            self.vectors(done, start_offsets + side * CALIBRATION.start_shift)
            for side in (-0.5, 0.5)
        )
        return [
            np.nan_to_num((b - a) / CALIBRATION.start_shift)
            for a, b in zip(before, after, strict=True)
        ]

    def bundle(
        self, values: Mapping[str, float], steps: Mapping[str, float], spread_over: Map = map
    ) -> Bundle:
        """Simulate at `values` and with each parameter of `steps` [SI] moved.

        A step that leaves a parameter's bounds, or fails, is taken the other way.
        """
        centre = self.run(values, spread_over)
        made = list(spread_over(lambda name: self._moved(values, name, steps[name]), steps))
        return Bundle(centre, dict(zip(steps, made, strict=True)))

    def _moved(
        self, values: Mapping[str, float], name: str, step: float
    ) -> tuple[list[Channels] | None, float]:
        low, high = self.plant.parameters.declared[name].bounds
        at = values.get(name, self.plant.parameters[name])
        for side in (step, -step):
            if low <= at + side <= high:
                try:
                    return self.run({**values, name: at + side}), side
                except ComputationFailed:
                    continue
        return None, step

    def sloped(
        self, values: Mapping[str, float], steps: Mapping[str, float], spread_over: Map = map
    ) -> Bundle | None:
        """As `bundle`, by the plant's own slopes, parts included; None where it has none."""
        slopes = getattr(self.plant, "slopes", None)
        if slopes is None:
            return None
        centre = self.run(values, spread_over)
        recordings = [self.views[group[0]].recording for group in self.groups]
        names = tuple(self.plant.judged)  # features look at channels that are not compared, too
        found = list(spread_over(lambda each: slopes(values, steps, each, names), recordings))
        moved: dict[str, tuple[list[Channels] | None, float]] = {}
        for name in dict.fromkeys(name for own in found for name in own):
            step = steps.get(name, PART_STEP)
            pairs = zip(centre, found, strict=True)
            moved[name] = [_by(run, own.get(name, {}), step) for run, own in pairs], step
        return Bundle(centre, moved)

    def derivatives(
        self, bundle: Bundle, sizes: Mapping[str, float], start_offsets: np.ndarray
    ) -> list[np.ndarray]:
        """Change of every run's vector by parameters times `sizes` [SI], shape (sizes, n) each.

        Zero where no step succeeded.
        """
        centre = self.vectors(bundle.centre, start_offsets)
        found = [np.zeros((len(sizes), each.size)) for each in centre]
        for row, (name, size) in enumerate(sizes.items()):
            moved, step = bundle.moved[name]
            if moved is not None:
                for rows, m, b in zip(
                    found, self.vectors(moved, start_offsets), centre, strict=True
                ):
                    rows[row] = size * np.nan_to_num((m - b) / step)
        return found


def _by(centre: Channels, slopes: Mapping[str, np.ndarray], step: float) -> Channels:
    """Channels with one parameter or part moved by `step`."""
    return {**centre, **{name: centre[name] + step * slope for name, slope in slopes.items()}}
