"""Where something is left of the gap: by condition, channel and phase, in noise floors of there."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.plants.protocol import Plant

SMALL = 2.0  # noise floors: what a small remainder is at most
SMALL_OF_FEW = 4.0  # the same where few repeats leave the mean itself uncertain
SMALL_SHARE = 0.1  # of what was there before, which a small remainder may be instead
LEAST_FLOOR = 0.3  # of a channel's noise floor: at rest it may be nearly none
FEWEST_RUNS = 4  # repeats that show the spread of one place; of fewer, the channel's counts
STATED_RUNS = 10.0  # that what is stated of runs counts for beside repeats
FEWEST = 20  # samples of a phase that count
TOUCH = 5e-3  # s, that a blow lasts at most; below 200 Hz it is one sample, which counts
BLOWS = 0.02  # of a phase, that blows last at most: what is off for more is no touch
FORCE = "N"

Raw = Sequence[Mapping[str, np.ndarray]]


@dataclass(frozen=True)
class Remainder:
    """What is left in one place beyond noise: RMS in noise floors of there, before and after.

    runs: repeats whose mean it is of
    """

    condition: str
    channel: str
    phase: str
    before: float
    after: float
    runs: int

    @property
    def small(self) -> bool:
        """Whether it is small beside noise, or beside what was there."""
        small = SMALL if self.runs >= FEWEST_RUNS else SMALL_OF_FEW
        return self.after <= max(small, SMALL_SHARE * self.before)

    @property
    def text(self) -> str:
        """`2.4 times the noise floor in the force while closing (dynamometer)`."""
        return (
            f"{self.after:.2g} times the noise floor in the {self.channel}, {self.phase} of "
            f"{self.condition}"
        )


def remainders(
    plant: Plant,
    segments: Sequence[Segment],
    before: Raw,
    after: Raw,
    noise_floors: Mapping[str, float],
    stated: Raw = (),
) -> list[Remainder]:
    """The remainder of every place, the largest first.

    before, after: simulated minus recorded of each segment, over its counted samples. Repeats are
    averaged; what their mean still holds of noise is subtracted. Of forces [N] a few samples that
    are off for less than `TOUCH` count for nothing: what joints are off for themselves moves a
    touch, which changes that are added up cannot.
    stated: by how much runs are said to differ there, one standard deviation of each sample, {} of
    a segment where that is not known. Repeats may be alike by chance.
    """
    found = []
    for numbers in repeated(plant, segments):
        first = segments[numbers[0]]
        for phase, mask in plant.phases(first.recording).items():
            inside = mask[first.mask]
            if np.count_nonzero(inside) < FEWEST:
                continue
            for name in (n for n in noise_floors if n in first.recording):
                old, new = ([raw[k][name][inside] for k in numbers] for raw in (before, after))
                brief = _brief(first.recording.time) if plant.channels[name] == FORCE else 1
                expected = _expected([stated[k] for k in numbers] if stated else (), name, inside)
                was, now = _sizes(old, new, noise_floors[name], expected, brief)
                found.append(Remainder(first.entry.condition, name, phase, was, now, len(numbers)))
    return sorted(found, key=lambda each: -each.after)


def _brief(time: np.ndarray) -> int:
    """Samples over which the median of a force's residual is taken: an odd number."""
    return 2 * round(TOUCH * (time.size - 1) / float(np.ptp(time))) + 1


def repeated(plant: Plant, segments: Sequence[Segment]) -> list[list[int]]:
    """Numbers of the segments that repeat each other."""
    found: dict[tuple[object, ...], list[int]] = {}
    for number, each in enumerate(segments):
        names = tuple(each.recording.names)
        key = each.entry.condition, plant.same_run(each.recording), each.mask.tobytes(), names
        found.setdefault(key, []).append(number)
    return list(found.values())


def _expected(stated: Raw, name: str, inside: np.ndarray) -> float:
    """Mean square by which repeats are stated to differ in a place; 0 where it is not known."""
    here = next((each[name] for each in stated if name in each), None)
    return 0.0 if here is None else float(np.mean(here[inside] ** 2))


def _sizes(
    before: Sequence[np.ndarray],
    after: Sequence[np.ndarray],
    channel_floor: float,
    expected: float,
    brief: int,
) -> Iterator[float]:
    """RMS of each mean residual in noise floors of the place, less the noise of that mean.

    expected: mean square by which runs are stated to differ there, which counts beside repeats
    brief: samples over which its median is taken
    """
    runs, floor = len(before), channel_floor
    if runs > 1:
        spread = np.array(after) - np.mean(after, axis=0)
        here = float(np.sum(spread**2) / (spread.size - spread.shape[1]))
        pooled = (here * (runs - 1) + expected * STATED_RUNS) / (runs - 1 + STATED_RUNS)
        least = LEAST_FLOOR if runs >= FEWEST_RUNS else 1.0
        floor = max(np.sqrt(max(here, pooled)), least * channel_floor)
    for rows in (before, after):
        square = float(np.mean(np.square(_without_blows(np.mean(rows, axis=0), brief))))
        yield float(np.sqrt(max(0.0, square - floor**2 / runs))) / floor


def _without_blows(mean: np.ndarray, brief: int) -> np.ndarray:
    """A mean residual whose farthest samples from the median around them are that median."""
    from scipy.ndimage import median_filter

    if brief == 1:
        return mean
    usual = median_filter(mean, brief, mode="nearest")
    off = np.abs(mean - usual)
    return np.where(off > np.quantile(off, 1.0 - BLOWS), usual, mean)


def largest(found: Sequence[Remainder]) -> Remainder | None:
    """The largest remainder that is not small, or None."""
    return next((each for each in found if not each.small), None)
