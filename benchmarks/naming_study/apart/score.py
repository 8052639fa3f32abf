"""A verdict beside the answer, by the words of the study's table.

right: exactly what is hidden, with a remainder or without; class: one of several, what is hidden
among them; wrong: any name that is not hidden, clean or with a remainder, or a class without what
is hidden; one: of several, with a remainder; part: of several, none wrong and not all named;
wide: a class of fingers with one that the true model's likelihood parts; unknown: something is
missing; silent: nothing is said to be missing, or too little recorded, or
the diagnosis failed.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.naming_study.score import CLAIMS, NAMING, pair, parameters, single
from benchmarks.truth.faults import Fault
from benchmarks.truth.parameters import FINGERS

# Laws that MuJoCo's own contact, wires and dry friction may well be.
MUJOCO_LAWS = ("hunt_crossley", "viscoelastic_object", "leader_slack", "wire_compliance", "capstan",
               "stribeck", "direction_friction", "gear_load", "guide_load")  # fmt: skip
ABSENT = ("no_gap", "recalibrated")
SECONDS = 120.0  # of a processor, for an answer
Said = Mapping[str, Any]  # a verdict


def sound(verdict: Said) -> str:
    """Of a hand that lacks nothing: silent, named, or called something else."""
    if verdict["verdict"] in CLAIMS:
        return "named"
    return "silent" if verdict["verdict"] in ABSENT else "called"


def outside(verdict: Said) -> str:
    """Of what no catalogue has: any name is wrong, clean or with a remainder."""
    if verdict["verdict"] in CLAIMS:
        return "wrong"
    return "unknown" if verdict["verdict"] == "unknown" else "silent"


def triple(verdict: Said, effects: list[str]) -> str:
    """Of three effects: all; two or more, none wrong; part, wrong, unknown or silent."""
    found = pair(verdict, effects)
    if found == "both":
        return "all"
    if found in ("one", "part") and verdict["verdict"] in NAMING and len(verdict["effects"]) > 1:
        return "two"
    return found


def fault(verdict: Said, true: Fault) -> str:
    """Of a fault of one finger: kind and finger, or a class of fingers with that kind.

    Whether the class is too wide is asked apart, see `parting`.
    """
    found = single(verdict, f"{true.finger}_{true.kind}")
    alike = {f"{finger}_{true.kind}" for finger in FINGERS}
    return "wrong" if found == "class" and not set(verdict["effects"]) <= alike else found


def mujoco(verdict: Said, effects: list[str]) -> str:
    """Of a hand with MuJoCo's laws: right where what is hidden is named, and all else that is named
    is a law of contact, wire or dry friction; class; sound: silent, law (such names alone), called
    something else, or wrong.
    """
    names = set(verdict["effects"]) - set(effects)
    if verdict["verdict"] not in CLAIMS:
        return sound(verdict) if not effects else single(verdict, effects[0])
    if verdict["verdict"] == "one_of" and effects:
        return single(verdict, effects[0])
    if names - set(MUJOCO_LAWS):
        return "wrong"
    if not effects:
        return "law"
    return "right" if set(effects) <= set(verdict["effects"]) else "wrong"


def outcome(what: str, verdict: Said, effects: list[str], true: Fault | None) -> str:
    """How a verdict counts."""
    if what == "sound":
        return sound(verdict)
    if what.startswith("MuJoCo"):
        return mujoco(verdict, effects)
    if what in ("opened", "sealed"):
        return outside(verdict)
    if true is not None:
        return fault(verdict, true)
    if what in ("pair", "triple"):
        return (pair if what == "pair" else triple)(verdict, effects)
    return single(verdict, effects[0])


def scores(
    what: str, verdict: Said, effects: list[str], sizes: Mapping[str, float], true: Fault | None
) -> dict[str, Any]:
    """All that a line of the study says of a case's verdict."""
    return {
        "outcome": outcome(what, verdict, effects, true),
        "verdict": verdict["verdict"],
        "named": verdict["effects"],
        "reason": verdict["reason"],
        "probability": verdict.get("probabilities", {}).get("answer"),
        "parameters": parameters(verdict, _answer(sizes)),
    }


def _answer(sizes: Mapping[str, float]) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for name, size in sizes.items():
        effect, _, parameter = name.partition(".")
        found.setdefault(effect, {})[parameter] = size
    return found


def late(case: Mapping[str, Any]) -> bool:
    """Whether there was no answer in time."""
    return case["verdict"] == "failed" or case["processor_seconds"] > SECONDS


def ended(cases: Sequence[Mapping[str, Any]], *outcomes: str) -> int:
    """Cases that end so, in time."""
    return sum(each["outcome"] in outcomes and not late(each) for each in cases)


def ended_or_late(cases: Sequence[Mapping[str, Any]], *outcomes: str) -> int:
    """Cases that end so, and those without an answer in time, which count as wrong."""
    return sum(each["outcome"] in outcomes or late(each) for each in cases)
