"""Which effects are easily confused, as measured on simulated campaigns."""

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

FILE = Path(__file__).with_suffix(".toml")
EASILY = 0.7  # cosine similarity from which on two effects count as confusable


@cache
def _measured() -> Mapping[str, Mapping[str, Mapping[str, float]]]:
    return tomllib.loads(FILE.read_text(encoding="utf-8"))


def confusable(effect: str) -> dict[str, dict[str, float]]:
    """What was recorded -> effects confusable with this one there, and the cosine similarity.

    Of signatures on a hand all of whose parameters are uncertain: 1 is the same. Empty for an
    effect that was not measured.
    """
    return {
        recorded: dict(table[effect]) for recorded, table in _measured().items() if effect in table
    }


def text(effect: str) -> str:
    """The same as lines of text, which say so of an effect that was not measured."""
    lines = []
    for recorded, others in confusable(effect).items():
        easily = [f"{name} {cosine:.2f}" for name, cosine in others.items() if cosine >= EASILY]
        lines.append(f"  {recorded}: {', '.join(easily) or 'none'}")
    if not lines:
        return "what it is easily confused with is not yet measured"
    return "\n".join(["easily confused with (cosine of signatures, measured):", *lines])
