"""A fault of one part of a machine: values of that part that are off, found as an effect is.

It adds nothing to the equations. Each of its amplitudes moves values that the plant has anyway, so
it is carried by values alone: what a diagnosis finds is written as these.
"""

import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field

from hannes.core.effect import Effect


@dataclass(frozen=True, repr=False)
class PartFault(Effect):
    """moves: amplitude -> the plant's parameter by full name -> its change per unit, SI."""

    moves: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Nothing to compile, nothing to check: the plant's parameters have bounds."""

    @property
    def acts(self) -> str:
        """What it changes, in a line."""
        moved = dict.fromkeys(name for each in self.moves.values() for name in each)
        return textwrap.fill(f"moves: {', '.join(moved)}", 76, subsequent_indent="    ")

    def __hash__(self) -> int:
        return hash(self.name)


def moved_by(effect: Effect, parameter: str) -> Mapping[str, float]:
    """What one of an effect's parameters moves of the plant's; nothing of an effect that adds."""
    return effect.moves.get(parameter, {}) if isinstance(effect, PartFault) else {}


def compiled_effects(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those that add to the equations."""
    return tuple(each for each in effects if not isinstance(each, PartFault))
