"""Noise floors by which a remainder is judged: what runs differ by, of few repeats as stated too.

Two repeats may be alike by chance. Their floor then lacks what runs differ by, and a shift of one
command's runs would look like something that is missing.
"""

from collections.abc import Mapping

import numpy as np

from hannes.identification.diagnosis.noise_covariance import NoiseCovariance
from hannes.identification.diagnosis.tuning import VERDICT


def remainder_floors(noise_floors: Mapping[str, float], noise: NoiseCovariance) -> dict[str, float]:
    """Floor of each channel [its unit]: that of repeats, or pooled with what is stated if more."""
    repeats = sum(group.count - 1 for group in noise.model.groups)
    weight = VERDICT.assumed_weight / (VERDICT.assumed_weight + repeats)
    return {
        name: max(floor, float(np.sqrt((1.0 - weight) * floor**2 + weight * _stated(noise, name))))
        for name, floor in noise_floors.items()
    }


def _stated(noise: NoiseCovariance, channel: str) -> float:
    """Mean square by which runs are stated to differ in a channel; 0 where none has it."""
    pairs = zip(noise.model.groups, noise.run_to_run, strict=True)
    squares = [
        np.mean(np.sum(rows[:, group.of(channel)] ** 2, axis=0))
        for group, rows in pairs
        if channel in group.names
    ]
    return float(np.mean(squares)) if squares else 0.0
