"""How one run is compared: bin means of its channels in the order of time, then its features.

Bins smooth the residual at contacts, which last a few samples, and keep it small.
"""

from collections.abc import Mapping

import numpy as np

from hannes.campaigns.campaign import Entry
from hannes.core.errors import BadInput
from hannes.identification.grasp_features import measure
from hannes.plants.protocol import Plant

BIN = 0.01  # s
BLOCKS_PER_PARAMETER = 2  # blocks that a recording must have for each parameter
FEW = 0.5  # of the usual number of samples in a bin: one with fewer does not count
PER_BLOCK = 20  # bins, at least, in the plant's block: the time over which residuals correlate


class View:
    """One recording as a vector, shape (n,), and the same of any simulation of it.

    `part` gives the channel or feature of every element by its index in `names`; `block` its block
    of time, `block_length` [s] long. Raises BadInput where no sample of the recording counts.
    """

    def __init__(
        self,
        entry: Entry,
        plant: Plant,
        channels: tuple[str, ...],
        features: tuple[str, ...],
        width: float | None = None,
    ) -> None:
        self.entry, self.recording = entry, entry.recording
        self.names = (*channels, *features)
        self.channels = tuple(name for name in channels if name in self.recording)
        self.since = self.recording.time - self.recording.time[0]
        self.features = self._sensible(features)
        self.block_length = plant.block
        mask = self._judged(plant)
        width = width or min(BIN, plant.block / PER_BLOCK)
        bins = (self.since / width + 1e-9).astype(int)
        mask = _whole(mask, bins)
        kept, self._bin = np.unique(bins[mask], return_inverse=True)
        self._mask, self._count = mask, np.bincount(self._bin)
        self.part = self._parts(kept.size)
        block = (kept * width / plant.block).astype(int)
        feature_blocks = np.full(len(self.features), block[-1] + 1)
        self.block = np.concatenate([*[block] * len(self.channels), feature_blocks])
        self.measured = self.of(self.recording.channels)

    def _judged(self, plant: Plant) -> np.ndarray:
        """Mask of the samples that count; there is at least one."""
        mask = plant.judged_part(self.recording)
        if not mask.any():
            raise BadInput(
                f"{self.entry.name}: expected samples that count, got none in "
                f"{self.since[-1]:.3g} s; record longer, or leave it out"
            )
        return mask

    def _sensible(self, features: tuple[str, ...]) -> tuple[str, ...]:
        found = measure(features, self.since, self.recording.channels)
        return tuple(name for name, value in zip(features, found, strict=True) if value == value)

    def _parts(self, bins: int) -> np.ndarray:
        places = [np.full(bins, self.names.index(name)) for name in self.channels]
        places.append(np.array([self.names.index(name) for name in self.features], int))
        return np.concatenate(places)

    @property
    def bins(self) -> int:
        """Number of bins of each channel."""
        return self._count.size

    @property
    def times(self) -> np.ndarray:
        """Mean time of each bin since the start [s]."""
        return np.bincount(self._bin, self.since[self._mask]) / self._count

    @property
    def max_parameters(self) -> int:
        """How many parameters this run can determine, at most."""
        traced = self.block[: self.block.size - len(self.features)]
        return len(set(traced.tolist())) // BLOCKS_PER_PARAMETER + len(self.features)

    def part_of(self, name: str) -> np.ndarray:
        """The recorded bins of a channel, or the value of a feature; empty where it has none."""
        return self.measured[self.part == self.names.index(name)]

    def samples(self, name: str) -> np.ndarray:
        """The recorded samples of a channel that count; empty where it has none."""
        return self.recording[name][self._mask] if name in self.channels else np.zeros(0)

    def of(self, channels: Mapping[str, np.ndarray], start_offset: float = 0.0) -> np.ndarray:
        """The vector of channels at the recorded times, for a run that starts late [s]."""
        moved = self._moved(channels, start_offset)
        means = [
            np.bincount(self._bin, moved[name][self._mask]) / self._count for name in self.channels
        ]
        return np.concatenate([*means, measure(self.features, self.since, moved)])

    def nonlinearities(self, channels: Mapping[str, np.ndarray]) -> np.ndarray:
        """Deviation of samples from a straight line in each bin or the next, RMS, shape (n,).

        Large at contacts, where a mean carries little information. Zero for features.
        """
        found = [self._nonlinearity(channels[name][self._mask]) for name in self.channels]
        return np.concatenate([*found, np.zeros(len(self.features))])

    def _nonlinearity(self, values: np.ndarray) -> np.ndarray:
        def mean(x: np.ndarray) -> np.ndarray:
            return np.bincount(self._bin, x) / self._count

        time = self.since[self._mask]
        time, level = time - mean(time)[self._bin], values - mean(values)[self._bin]
        slope = mean(time * level) / np.maximum(mean(time**2), 1e-30)
        own = np.sqrt(mean((level - slope[self._bin] * time) ** 2))
        edged = np.concatenate((own[:1], own, own[-1:]))
        return np.maximum(own, np.maximum(edged[:-2], edged[2:]))

    def _moved(
        self, channels: Mapping[str, np.ndarray], start_offset: float
    ) -> Mapping[str, np.ndarray]:
        if start_offset == 0.0:
            return channels
        wanted = channels if self.features else self.channels
        return {
            name: np.interp(self.since - start_offset, self.since, channels[name])
            for name in wanted
            if name != "time"
        }


def _whole(mask: np.ndarray, bins: np.ndarray) -> np.ndarray:
    """The mask without bins of few samples: their means are noisier than those of the others."""
    counts = np.bincount(bins[mask], minlength=int(bins[-1]) + 1)
    return mask & (counts >= FEW * np.median(counts[counts > 0]))[bins]
