"""A fault of one part of a machine, or a setting: values that are off, found as an effect is.

It adds nothing to the equations. Each of its amplitudes moves values that the plant has anyway, so
it is carried by values alone: what a diagnosis finds is written as these.
"""

import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from hannes.core.effect import Effect


@dataclass(frozen=True, repr=False)
class PartFault(Effect):
    """A fault of one of several like parts, or a setting that is other than stated.

    moves: amplitude -> the plant's parameter by full name -> its change per unit, SI
    kind:  what other parts may have as well; empty of a setting, which has none like it
    by_run: whether it moves them once for each run of the campaign that came before
    """

    moves: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    kind: str = ""
    by_run: bool = False

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


def moves_by_run(effect: Effect) -> bool:
    """Whether an effect moves values of the machine further with every run of a campaign."""
    return isinstance(effect, PartFault) and effect.by_run


def part_faults(effects: Mapping[str, Effect], names: Iterable[str]) -> list[str]:
    """Those of the names that are faults of one of several like parts."""
    return [name for name in names if _kind(effects[name])]


def _kind(effect: Effect | None) -> str:
    return effect.kind if isinstance(effect, PartFault) else ""


def like_faults(effects: Mapping[str, Effect], name: str) -> list[str]:
    """The same fault of the other parts; none of an effect that adds to the equations."""
    kind = _kind(effects.get(name))
    return [
        other for other, each in effects.items() if kind and _kind(each) == kind and other != name
    ]


def compiled_effects(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Those that add to the equations."""
    return tuple(each for each in effects if not isinstance(each, PartFault))
