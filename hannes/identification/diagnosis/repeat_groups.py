"""Groups of recordings under one command, which share a simulation, as vectors of bin means."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.parameter import EARLIER
from hannes.core.recording.recording import Recording
from hannes.identification.binned_run import BIN, View
from hannes.identification.diagnosis.tuning import FIT
from hannes.plants.protocol import Plant

Channels = Mapping[str, np.ndarray]


class Group:
    """Repeats of one run, in bins as wide as quick simulations allow, or so many times finer.

    measured: their bin means, shape (runs, n); `part` and `names` give an element's channel
    nominal:  full name -> nominal value of every parameter in this run (SI)
    recording: the first run's, and where the plant reads what was measured (where a run starts),
               the mean over the runs
    owner, own: the object handled, and the parameters that belong to it alone
    numbers: how many runs of the campaign came before each, shape (runs,)
    earlier: what these did, see campaigns/earlier_runs.py, name -> shape (runs,)
    """

    def __init__(self, plant: Plant, entries: Sequence[Entry], finer: int = 1) -> None:
        channels = tuple(name for name in plant.judged if name in entries[0].recording)
        duration = float(np.ptp(entries[0].recording.time))
        self.width = _whole_samples(
            max(BIN, duration / FIT.bins) / finer, entries[0].recording.time
        )
        self.entries = tuple(entries)
        self.numbers = np.array([each.number for each in entries])
        self.earlier = {
            name: np.array([each.earlier.get(name, np.nan) for each in entries]) for name in EARLIER
        }
        self.views = [View(each, plant, channels, (), self.width) for each in entries]
        self.recording = _together([each.recording for each in entries], plant.required)
        self.names, self.part = self.views[0].channels, self.views[0].part
        self.bins = self.views[0].bins
        self.measured = np.array([view.measured for view in self.views])
        self.nominal, (self.owner, self.own) = nominal_values(plant, self.recording)

    def only(self, runs: Sequence[int]) -> "Group":
        """The same with some of the runs, simulated as before."""
        made = copy(self)
        made.entries = tuple(self.entries[k] for k in runs)
        made.numbers = self.numbers[list(runs)]
        made.earlier = {name: each[list(runs)] for name, each in self.earlier.items()}
        made.views = [self.views[k] for k in runs]
        made.measured = self.measured[list(runs)]
        return made

    @property
    def count(self) -> int:
        """Number of runs."""
        return len(self.views)

    @property
    def mean(self) -> np.ndarray:
        """Bin means averaged over the runs, shape (n,)."""
        return self.measured.mean(axis=0)

    def vector(self, channels: Channels, start_offset: float = 0.0) -> np.ndarray:
        """Bin means, shape (n,), of a simulation that starts `start_offset` [s] late."""
        return self.views[0].of(channels, start_offset)

    def nonlinearity(self, channels: Channels) -> np.ndarray:
        """Deviation of samples from a straight line in each bin, see View.nonlinearities."""
        return self.views[0].nonlinearities(channels)

    def onsets(self, channels: Channels, within: float) -> np.ndarray:
        """What a channel that is zero next to a touch reaches as long on its other side, (n,).

        within: time [s] from the touch; 0 beyond, and where a channel is not zero
        """
        vector, most = self.vector(channels), max(1, round(within / self.width))
        return np.concatenate([_mirrored(vector[self.of(name)], most) for name in self.names])

    def of(self, name: str) -> slice:
        """Where a channel lies in the vector."""
        first = self.names.index(name) * self.bins
        return slice(first, first + self.bins)


def _whole_samples(width: float, time: np.ndarray) -> float:
    """The width [s] of bins, or a little more, in which there are as many samples each.

    A mean of six is noisier than one of seven. Where samples are further apart, any width does.
    """
    interval = float(np.median(np.diff(time)))
    if interval >= width:
        return round(width, 6)
    return max(width, float(interval * np.ceil(width / interval - 1e-6)))


def _together(recordings: Sequence[Recording], read: Sequence[str]) -> Recording:
    """The first recording, with the mean over all of them of what differs of what is `read`."""
    first = recordings[0]
    differing = {
        name: np.mean([each[name] for each in recordings], axis=0)
        for name in read
        if any(not np.array_equal(each[name], first[name]) for each in recordings)
    }
    return replace(first, channels={**first.channels, **differing}) if differing else first


def _mirrored(values: np.ndarray, most: int) -> np.ndarray:
    """At zeros, the size of what lies as far beyond the nearest other value, up to `most` away.

    Or one bin further, where that is larger: a touch lies somewhere in its bin.
    """
    found, there = np.zeros(values.size), values != 0.0
    if there.all() or not there.any():
        return found
    outward = np.arange(most)
    for edge in np.flatnonzero(there[1:] != there[:-1]):
        inside, outside, inward = edge + 1 + outward, edge - outward, 1
        if there[edge]:
            inside, outside, inward = edge - outward, edge + 1 + outward, -1
        known = (np.minimum(inside, outside) >= 0) & (np.maximum(inside, outside) < values.size)
        quiet = known & ~there[np.where(known, outside, 0)]
        further = (inside[quiet] + inward).clip(0, values.size - 1)
        reached = np.maximum(np.abs(values[inside[quiet]]), np.abs(values[further]))
        found[outside[quiet]] = np.maximum(found[outside[quiet]], reached)
    return found


def nominal_values(
    plant: Plant, recording: object
) -> tuple[dict[str, float], tuple[str, tuple[str, ...]]]:
    """A run's nominal parameters, and which of them belong to the object that it handles."""
    nominal, own = getattr(plant, "nominal", None), getattr(plant, "own", None)
    return (
        nominal(recording) if nominal else dict(plant.parameters),
        own(recording) if own else ("", ()),
    )


def one_by_one(groups: Sequence[Group]) -> list[Group]:
    """A group for each run."""
    return [group.only([k]) for group in groups for k in range(group.count)]


def grouped(plant: Plant, entries: Sequence[Entry]) -> list[Group]:
    """Groups of repeats in the order of the recordings."""
    found: dict[tuple[bytes, tuple[str, ...], int], list[Entry]] = {}
    for entry in entries:
        recording = entry.recording
        names = tuple(name for name in plant.judged if name in recording)
        kind = plant.same_run(recording), names, len(recording)
        found.setdefault(kind, []).append(entry)
    return [Group(plant, each) for each in found.values()]
