"""What a hand's catalogue has beside effects: faults, settings and drifts, all by moved values."""

from collections.abc import Mapping

from hannes.core.effect import Effect
from hannes.plants.hand.falling_supply import falling_supply
from hannes.plants.hand.finger_faults import faults
from hannes.plants.hand.other_settings import other_settings


def moved_values(values: Mapping[str, float]) -> dict[str, Effect]:
    """By name: faults of one finger, settings other than stated, what changes from run to run.

    values: the hand's parameters as they are stated [SI]
    """
    return {**faults(values), **other_settings(values), **falling_supply()}
