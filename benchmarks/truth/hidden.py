"""All that a hand of the truth can hide by name: effects, and settings other than stated."""

from collections.abc import Mapping

from benchmarks.truth import effects
from benchmarks.truth.settings import RANGES

SIZES = {**effects.SIZES, **RANGES}


def of_effects(hidden: Mapping[str, float]) -> dict[str, float]:
    """Those of `hidden` that the equations have."""
    return {name: size for name, size in hidden.items() if name not in RANGES}
