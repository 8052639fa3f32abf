"""A verdict beside the answer: right, class, wrong, silent, unknown, and by how much.

right: the effect's name alone; class: one of several, the effect among them; wrong: any name that
is not hidden, or a class without the effect; unknown: something is missing; silent: nothing is said
to be missing, or too little recorded to say, or the diagnosis failed.
"""

from collections.abc import Mapping
from typing import Any

from benchmarks.truth.hidden import SIZES

NAMING = ("named", "named_with_remainder")
CLAIMS = (*NAMING, "one_of")


def single(verdict: Mapping[str, Any], effect: str) -> str:
    """How a verdict on one hidden effect counts."""
    said, names = verdict["verdict"], verdict["effects"]
    if said in NAMING:
        return "right" if names == [effect] else "wrong"
    if said == "one_of":
        return "class" if effect in names else "wrong"
    return "unknown" if said == "unknown" else "silent"


def empty(verdict: Mapping[str, Any]) -> str:
    """How a verdict on a hand without any effect counts: named, unknown or silent."""
    if verdict["verdict"] in CLAIMS:
        return "named"
    return "unknown" if verdict["verdict"] == "unknown" else "silent"


def outside(verdict: Mapping[str, Any]) -> str:
    """Of an effect that no catalogue has: unknown, remainder, wrong (a clean name), silent."""
    if verdict["verdict"] == "named_with_remainder":
        return "remainder"
    return {"named": "wrong", "one_of": "wrong", "unknown": "unknown"}.get(
        verdict["verdict"], "silent"
    )


def pair(verdict: Mapping[str, Any], effects: list[str]) -> str:
    """Of two effects: both, one (and a remainder reported), part, wrong, unknown, silent.

    part: only one is named, or a class with one in it, and nothing is said to remain.
    """
    said, names = verdict["verdict"], verdict["effects"]
    if said == "one_of":
        return "part" if set(names) & set(effects) else "wrong"
    if said not in NAMING:
        return "unknown" if said == "unknown" else "silent"
    if set(names) - set(effects):
        return "wrong"
    if set(names) == set(effects):
        return "both"
    return "one" if said == "named_with_remainder" else "part"


def scores(what: str, case: Mapping[str, Any], effects: list[str]) -> dict[str, Any]:
    """All that a line of the study says of a case's verdict."""
    verdict = case["verdict"]
    if what == "empty":
        found = empty(verdict)
    elif what == "outside":
        found = outside(verdict)
    elif what == "pair":
        found = pair(verdict, effects)
    else:
        found = single(verdict, effects[0])
    return {
        "outcome": found,
        "verdict": verdict["verdict"],
        "named": verdict["effects"],
        "probability": verdict.get("probabilities", {}).get("answer"),
        "left": case.get("left"),
        "placebo": placebo(verdict, effects),
        "parameters": parameters(verdict, case["answer"]),
        "next_run": verdict.get("next_run"),
    }


def placebo(verdict: Mapping[str, Any], effects: list[str]) -> float | None:
    """What the best of all other effects took of the misfit that could be taken, fitted."""
    gains = [
        each["gain_select"]
        for each in verdict.get("candidates", ())
        if each["effect"] not in effects and each["gain_select"] is not None
    ]
    return max(gains, default=None)


def parameters(
    verdict: Mapping[str, Any], answer: Mapping[str, Mapping[str, float]]
) -> dict[str, dict[str, Any]]:
    """Relative error and coverage of each hidden amplitude that the verdict gives."""
    found_parameters = verdict.get("parameters", {})
    found = {}
    for effect, sizes in answer.items():
        for name, true in sizes.items():
            each = found_parameters.get(f"{effect}.{name}")
            if each is not None and SIZES[f"{effect}.{name}"].amplitude:
                found[f"{effect}.{name}"] = {
                    "error": abs(each["value"] / true - 1.0),
                    "covers": each["low"] <= true <= each["high"],
                }
    return found
