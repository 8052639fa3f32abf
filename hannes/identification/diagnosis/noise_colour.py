"""The bandwidth of the sensors' noise in all runs, which their repeats show."""

from collections.abc import Callable, Sequence

from hannes.identification.diagnosis.repeat_groups import Group
from hannes.plants.protocol import Plant


def noise_bandwidth(plant: Plant, groups: Sequence[Group]) -> float | None:
    """Bandwidth [Hz], 0 for white noise; None where no repeats show it, or no plant asks."""
    asked: Callable[..., float | None] | None = getattr(plant, "noise_bandwidth", None)
    repeats = [[each.recording for each in group.entries] for group in groups]
    return asked(repeats) if asked else None
