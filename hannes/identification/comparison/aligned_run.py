"""A recording and its simulation at the same times, counted from the start of the command."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.campaign import Entry

SAMPLING = 1000.0  # Hz, of the metrics
MOVED = 1e-3  # share of the command's range from which it has started

Channels = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class AlignedRun:
    """One recording and its simulation, by channel, shape (n,), at `time` [s], every 1 ms.

    `shift`: time [s] of the recording at which its command starts; there `time` is zero.
    `stiffness`: of the object [N/m], None where the experiment has none.
    """

    entry: Entry
    time: np.ndarray
    reference: np.ndarray
    measured: Channels
    simulated: Channels
    shift: float
    stiffness: float | None

    @property
    def unit(self) -> str:
        """Name of the machine, empty where the campaign does not say."""
        return self.entry.unit

    @property
    def touch(self) -> str:
        """Channel that shows contact: the phalanges' force, else a dynamometer's; or none."""
        return next((name for name in ("force", "sensor") if name in self.measured), "")


def aligned_run(entry: Entry, simulated: Channels, stiffness: float | None) -> AlignedRun:
    """Resample a recording and its `simulated` channels, which have its times."""
    recording = entry.recording
    reference = recording["reference"] if "reference" in recording else simulated["reference"]
    start = command_start(reference)
    shift = float(recording.time[start])
    since = recording.time - shift
    time = np.arange(0.0, since[-1] + 1e-9, 1.0 / SAMPLING)
    names = [name for name in recording.names if name in simulated and name != "reference"]

    def resampled(values: np.ndarray) -> np.ndarray:
        return np.interp(time, since, values)

    return AlignedRun(
        entry,
        time,
        resampled(reference),
        {name: resampled(recording[name]) for name in names},
        {name: resampled(simulated[name]) for name in names},
        shift,
        stiffness,
    )


def command_start(reference: np.ndarray) -> int:
    """Index of the last sample before a command moves; 0 where it never does."""
    moved = np.abs(reference - reference[0]) > MOVED * np.ptp(reference)
    return max(0, int(np.argmax(moved)) - 1)
