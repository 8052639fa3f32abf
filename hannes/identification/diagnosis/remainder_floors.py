"""Noise floors by which a remainder is judged: what runs differ by, of few repeats as stated too.

Two repeats may be alike by chance. Their floor then lacks what runs differ by, and a shift of one
command's runs would look like something that is missing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from hannes.campaigns.segments import Segment
from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.repeat_groups import Channels
from hannes.identification.diagnosis.tuning import VERDICT
from hannes.identification.remainder import Raw


def remainder_floors(noise_floors: Mapping[str, float], noise: NoiseCovariance) -> dict[str, float]:
    """Floor of each channel [its unit]: that of repeats, or pooled with what is stated if more."""
    repeats = sum(group.count - 1 for group in noise.model.groups)
    weight = VERDICT.assumed_weight / (VERDICT.assumed_weight + repeats)
    return {
        name: max(floor, float(np.sqrt((1.0 - weight) * floor**2 + weight * _stated(noise, name))))
        for name, floor in noise_floors.items()
    }


def stated_spread(noise: NoiseCovariance, segments: Sequence[Segment]) -> Raw:
    """One standard deviation by which runs are stated to differ: of each segment over its counted
    samples, channel -> shape (n,); {} of a command that was not fitted.
    """
    found = [_by_channel(noise, number) for number in range(len(noise.model.groups))]
    places = {id(e): k for k, group in enumerate(noise.model.groups) for e in group.entries}
    return [_sampled(found[places[id(s.entry)]], s) if id(s.entry) in places else {}
            for s in segments]  # fmt: skip


def _by_channel(noise: NoiseCovariance, number: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Times [s] of a group's bins and the spread there, by channel."""
    group = noise.model.groups[number]
    spread = np.sqrt(np.sum(noise.run_to_run[number] ** 2, axis=0))
    return {name: (group.views[0].times, spread[group.of(name)]) for name in group.names}


def _sampled(found: Mapping[str, tuple[np.ndarray, np.ndarray]], segment: Segment) -> Channels:
    since = segment.recording.time - segment.recording.time[0]
    return {name: np.interp(since, *each)[segment.mask] for name, each in found.items()}


def _stated(noise: NoiseCovariance, channel: str) -> float:
    """Mean square by which runs are stated to differ in a channel; 0 where none has it."""
    pairs = zip(noise.model.groups, noise.run_to_run, strict=True)
    squares = [
        np.mean(np.sum(rows[:, group.of(channel)] ** 2, axis=0))
        for group, rows in pairs
        if channel in group.names
    ]
    return float(np.mean(squares)) if squares else 0.0
