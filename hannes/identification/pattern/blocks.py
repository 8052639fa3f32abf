"""Residuals of repeated runs as means of short blocks, in noise floors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.identification.remainder import LEAST_FLOOR, Raw, repeated
from hannes.plants.protocol import Plant

BLOCKS = 48  # of a run
SHORTEST = 10e-3  # s, of a block
NEIGHBOURS = 5  # blocks, over which the spread of runs is pooled


@dataclass(frozen=True)
class Command:
    """Runs under one command.

    residual: simulated minus recorded in noise floors, shape (runs, blocks, channels)
    spread: how runs differ in each block, in noise floors, shape (blocks, channels)
    numbers: place of each run among all of the campaign
    quantities: what the residual may go with, name -> mean over each block, shape (blocks,)
    masks: conditions, phases and contact: name -> share of each block inside, shape (blocks,)
    """

    condition: str
    residual: np.ndarray
    spread: np.ndarray
    numbers: np.ndarray
    quantities: Mapping[str, np.ndarray]
    masks: Mapping[str, np.ndarray]

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return len(self.residual)

    @property
    def square(self) -> np.ndarray:
        """Square of what all runs share, shape (blocks, channels): products of different runs.

        Its mean is zero where runs share nothing, however noisy they are.
        """
        whole = self.residual.sum(axis=0) ** 2 - (self.residual**2).sum(axis=0)
        return np.asarray(whole / (self.runs * (self.runs - 1)))

    @property
    def clear(self) -> np.ndarray:
        """The same in the spread of runs there: what a moving edge differs by counts less."""
        return np.asarray(self.square / self.spread**2)

    def without(self, run: int) -> "Command":
        """The same without one run."""
        kept = np.arange(self.runs) != run
        return replace(self, residual=self.residual[kept], numbers=self.numbers[kept])

    def only(self, kept: np.ndarray) -> "Command":
        """The same in some of its blocks, a mask of shape (blocks,)."""
        return replace(
            self,
            residual=self.residual[:, kept],
            spread=self.spread[kept],
            quantities={name: each[kept] for name, each in self.quantities.items()},
            masks={name: each[kept] for name, each in self.masks.items()},
        )


def commands(
    plant: Plant,
    segments: Sequence[Segment],
    raw: Raw,
    noise_floors: Mapping[str, float],
    fewest: int,
) -> tuple[list[Command], list[str]]:
    """Commands of at least so many runs, and the channels that all of them have."""
    alike = [each for each in repeated(plant, segments) if len(each) >= fewest]
    there = [{n for n in noise_floors if n in raw[each[0]]} for each in alike]
    names = [n for n in noise_floors if any(n in some for some in there)]
    return [_command(plant, segments, raw, each, names, noise_floors) for each in alike], names


def _command(
    plant: Plant,
    segments: Sequence[Segment],
    raw: Raw,
    numbers: Sequence[int],
    names: Sequence[str],
    noise_floors: Mapping[str, float],
) -> Command:
    """Runs of one command; a channel that they lack is zero."""
    first = segments[numbers[0]]
    block = _blocks(first)
    count = np.bincount(block)
    rows = np.zeros((len(numbers), count.size, len(names)))
    for row, number in zip(rows, numbers, strict=True):
        for k, name in enumerate(names):
            if name in raw[number]:
                row[:, k] = np.bincount(block, raw[number][name]) / count / noise_floors[name]

    def mean(values: np.ndarray) -> np.ndarray:
        whole = np.asarray(values, float)[first.mask]
        return np.asarray(np.bincount(block, whole) / count)

    known = getattr(plant, "quantities", None)
    quantities = {n: mean(v) for n, v in known(first.recording).items()} if known else {}
    quantities["time"] = mean(first.recording.time - first.recording.time[0])
    masks = {name: mean(each) for name, each in plant.phases(first.recording).items()}
    if "contact" in quantities:
        masks["contact"] = quantities.pop("contact")
    order = np.array([segments[k].entry.number for k in numbers])
    return Command(first.entry.condition, rows, _spread(rows), order, quantities, masks)


def _spread(rows: np.ndarray) -> np.ndarray:
    """Standard deviation of runs in each block, over its neighbours too, (blocks, channels)."""
    from scipy.ndimage import uniform_filter1d

    here = np.sum((rows - rows.mean(axis=0)) ** 2, axis=0) / (len(rows) - 1)
    there = uniform_filter1d(here, NEIGHBOURS, axis=0, mode="nearest")
    return np.asarray(np.sqrt(np.maximum(there, LEAST_FLOOR**2)))


def _blocks(segment: Segment) -> np.ndarray:
    """Number of the block of each counted sample; every block has samples."""
    time = segment.recording.time[segment.mask]
    since = time - time[0]
    width = max(SHORTEST, float(since[-1]) / BLOCKS)
    last = max(int(np.ceil(float(since[-1]) / width - 1e-9)) - 1, 0)  # the run's end is in it
    return np.unique(np.minimum((since / width).astype(int), last), return_inverse=True)[1]
