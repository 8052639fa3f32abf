"""How well runs are predicted, above all those that were not fitted."""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.identification.binned_run import View
from hannes.identification.calibration.linearisation import State
from hannes.identification.calibration.simulator import Channels
from hannes.identification.calibration.tuning import CALIBRATION


def prediction(found: State, entries: Sequence[Entry]) -> dict[str, dict[str, float]]:
    """Channel -> RMS of simulated minus recorded [its unit]: `as_given`, `after`; `recorded`.

    Over all counted samples of `entries`. Every run is aligned in time first, before and after.
    """
    sums: dict[str, np.ndarray] = {}
    plant = found.model.plant
    simulated: dict[bytes, list[Channels]] = {}  # of repeats once
    for entry in entries:
        view = View(entry, plant, found.plan.channels, ())
        mask, run = plant.judged_part(entry.recording), plant.same_run(entry.recording)
        if run not in simulated:
            points: tuple[Mapping[str, float], ...] = ({}, found.all_values)
            simulated[run] = [plant.simulate(values, entry.recording) for values in points]
        runs = [_aligned(found, view, channels) for channels in simulated[run]]
        for name in view.channels:
            recorded = entry.recording[name][mask]
            residuals = [run[name][mask] - recorded for run in runs]
            squares = [float(np.sum(each**2)) for each in (*residuals, recorded)]
            sums[name] = sums.get(name, np.zeros(4)) + np.array([*squares, recorded.size])
    return {name: _roots(total) for name, total in sums.items()}


def _roots(total: np.ndarray) -> dict[str, float]:
    roots = np.sqrt(total[:3] / max(total[3], 1.0)).tolist()
    return dict(zip(("as_given", "after", "recorded"), roots, strict=True))


def _aligned(found: State, view: View, channels: Channels) -> Channels:
    """Channels of a simulation, moved to start when it fits the recording best."""
    start_offset, spread = 0.0, found.plan.start_time
    for _ in range(CALIBRATION.start_rounds if spread else 0):
        noise = found.noise[view.part]
        residual = (view.of(channels, start_offset) - view.measured) / noise
        moved = (
            (
                view.of(channels, start_offset + CALIBRATION.start_shift)
                - view.of(channels, start_offset)
            )
            / CALIBRATION.start_shift
            / noise
        )
        start_offset -= float(moved @ residual) / (float(moved @ moved) + 1.0 / spread**2)
    since = view.since
    return {name: np.interp(since - start_offset, since, channels[name]) for name in view.channels}
