"""What a page says of the effects that a verdict names: words, equation, and where they sit."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hannes.core.effect import Effect
from hannes.identification.effect_words import effect_words
from hannes.plants.plant_file import base_name
from hannes.report.schematic import schematic
from hannes.report.schematic_layout import parts_of
from hannes.simulation import catalogue

if TYPE_CHECKING:
    from hannes.report.diagnosed import Diagnosis

PART_WORDS = {"mcp": "MCP joints", "pip": "PIP joints", "joint": "joints", "cart": "carts"}


@dataclass(frozen=True)
class Explained:
    """One effect for a reader; `parts` of the hand is empty where the plant is another."""

    title: str
    meaning: str
    equation: str
    source: str
    parts: str


def explained_effects(diagnosis: "Diagnosis") -> list[Explained]:
    """Each effect that the verdict names, in its order."""
    known = known_effects(diagnosis)
    found = [(name, known.get(name)) for name in diagnosis.verdict.effects]
    return [_explained(name, each, _is_hand(diagnosis)) for name, each in found if each]


def known_effects(diagnosis: "Diagnosis") -> Mapping[str, Effect]:
    """Effects by the names under which a verdict speaks of them."""
    own = getattr(diagnosis.plant, "catalogue", {})
    return {**catalogue.effects(), **own, **diagnosis.campaign.effects}


def marked_schematic(diagnosis: "Diagnosis") -> str:
    """The hand's drawing with the named effects' parts marked; empty where there is nothing."""
    known = known_effects(diagnosis)
    named = [known[name] for name in diagnosis.verdict.effects if name in known]
    if not named or not _is_hand(diagnosis):
        return ""
    return schematic(getattr(diagnosis.plant, "hand", None), [each.name for each in named])


def _is_hand(diagnosis: "Diagnosis") -> bool:
    return diagnosis.campaign.base == base_name("hand")


def _explained(name: str, effect: Effect, on_hand: bool) -> Explained:
    parts = parts_of(effect) if on_hand else ()
    return Explained(
        effect_words(name).capitalize(),
        effect.meaning,
        effect.equation,
        effect.source,
        " and ".join(PART_WORDS.get(part, part) for part in parts),
    )
