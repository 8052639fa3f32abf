"""The probability of an answer in words."""

from collections.abc import Mapping
from typing import Any

from hannes.identification.effect_words import effect_words

SAID = 0.01  # probability from which another explanation is said beside the answer
MOST = 2  # of these
ANSWERS = {
    "no_gap": "nothing is missing",
    "recalibrated": "nothing is missing",
    "named": "this is what is missing",
    "one_of": "it is one of these",
    "named_with_remainder": "this is missing, whatever else is",
    "undecided": "these recordings do not decide it",
    "unknown": "something is missing that no known effect explains",
}


def probability_sentence(found: Mapping[str, Any], verdict: str, named: list[str]) -> str:
    """`Probability that this is what is missing: 97 %. Else: lag 2 %.`; empty without.

    found: the table of the verdict;  named: its effects
    """
    if not found:
        return ""
    others = _others(found, verdict, named)[:MOST]
    beside = ", ".join(f"{what} {_percent(each)}" for what, each in others)
    rest = f" Else: {beside}." if beside else ""
    each = _members(found, named) if verdict == "one_of" else ""
    return f"Probability that {ANSWERS[verdict]}: {_percent(found['answer'])}{each}.{rest}"


def _members(found: Mapping[str, Any], named: list[str]) -> str:
    """` (lag 61 %, delay 36 %)`: of each of a class."""
    alone = {each["effects"][0]: each["probability"] for each in found["effects"]
             if len(each["effects"]) == 1}  # fmt: skip
    shown = [f"{effect_words(name)} {_percent(alone[name])}" for name in named if name in alone]
    return f" ({', '.join(shown)})" if len(shown) > 1 else ""


def _others(found: Mapping[str, Any], verdict: str, named: list[str]) -> list[tuple[str, float]]:
    """What else may be, the likeliest first."""
    rows = [
        (" with ".join(map(effect_words, each["effects"])), each["probability"])
        for each in found["effects"]
        if not set(each["effects"]) & set(named)
    ]
    if verdict not in ("no_gap", "recalibrated"):
        rows.append(("nothing is missing", found["nothing"]))
    if verdict not in ("unknown", "named_with_remainder"):
        rows.append(("something in no catalogue", found["something_else"]))
    return sorted((row for row in rows if row[1] >= SAID), key=lambda row: -row[1])


def _percent(probability: float) -> str:
    """`97 %`; never certain."""
    if probability > 0.99:
        return "over 99 %"
    if probability < 0.01:
        return "under 1 %"
    return f"{100.0 * probability:.0f} %"
