"""All that a hand of the truth can hide by name: effects, settings, what changes by runs."""

from collections.abc import Mapping, Sequence

from benchmarks.truth import battery, effects
from benchmarks.truth.parameters import to_si
from benchmarks.truth.settings import RANGES
from hannes.core.errors import BadInput

_OF_VALUES = {**RANGES, **battery.RANGES}
SIZES = {**effects.SIZES, **_OF_VALUES}


def of_effects(hidden: Mapping[str, float]) -> dict[str, float]:
    """Those of `hidden` that the equations have."""
    return {name: size for name, size in hidden.items() if name not in _OF_VALUES}


def hidden_from(words: Sequence[str]) -> dict[str, float]:
    """ "leader_slack.length=3 mm" -> SI, by full name; BadInput otherwise."""
    found = {}
    for word in words:
        name, sign, text = word.partition("=")
        if not sign or name.strip() not in SIZES:
            raise BadInput(f'"{word}": expected NAME=SIZE, NAME one of {", ".join(SIZES)}')
        try:
            found[name.strip()] = to_si(text.strip(), SIZES[name.strip()].unit)
        except ValueError as error:
            raise BadInput(f'"{word}": {error}') from None
    return found
