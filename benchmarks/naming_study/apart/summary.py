"""From cases to the study's table: every case of a row is in its denominator.

A bound is a count of cases; where fewer are measured it is its share of them. A bound that is
missed by no more than one standard error of its count is shown as such, and does not block.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.harness import Row, interval, must_show
from benchmarks.naming_study.apart.bench import OUTSIDE
from benchmarks.naming_study.apart.kinds import KINDS
from benchmarks.naming_study.apart.score import ended, ended_or_late, late
from benchmarks.naming_study.probabilities import probabilities

Case = dict[str, Any]
Cases = Sequence[Case]
RIGHT = ("right", "class")
NAMES, FINGERS = 1.3, 2.0  # mean size of an answer that is right, at most
ERROR, COVERS, CLOSES = 0.05, (0.90, 0.98), 0.60


def figures(done: Cases) -> tuple[list[Row], list[Row]]:
    """A row of each kind that has cases, with the other figures; and what must be shown."""
    made = [case for case in done if "outcome" in case]
    rows = [_row(kind.name, [c for c in done if c["kind"] == kind.name]) for kind in KINDS]
    parts: tuple[Callable[[Cases], list[Row]], ...] = (
        singles, sound, several, faults, outside, mujoco, sizes, probabilities,
    )  # fmt: skip
    return [row for row in rows if row["cases"]], [row for part in parts for row in part(made)]


def at_least(name: str, value: int, cases: int, bound: int, of: int) -> Row:
    """A count that must be as high as `bound` of `of` cases."""
    share = bound / of
    return _counted(name, value, cases, share, value - share * cases)


def at_most(name: str, value: int, cases: int, bound: int, of: int) -> Row:
    """A count that must be as low as `bound` of `of` cases."""
    share = bound / of
    return _counted(name, value, cases, share, share * cases - value)


def _counted(name: str, value: int, cases: int, share: float, spare: float) -> Row:
    """spare: how far the bound is kept, negative where it is missed."""
    error = float(np.sqrt(cases * share * (1.0 - share)))
    row = must_show(f"{name}, of {cases}", value, share * cases, spare >= 0.0)
    missed = "" if spare >= 0.0 else "by one standard error or less" if spare >= -error else "yes"
    return {**row, "missed": missed}


def singles(done: Cases) -> list[Row]:
    """Single effects: right or a class with it, and wrong; of all, and of users who state none."""
    some = _of(done, "single")
    if not some:
        return []
    naive = [each for each in some if each["protocol"] == "naive"]
    rows = [at_least("single effects: right or a class", ended(some, *RIGHT), len(some), 135, 150)]
    if naive:
        rows.append(
            at_least("single, naive: right or a class", ended(naive, *RIGHT), len(naive), 40, 50)
        )
    wrong = ended_or_late(some, "wrong")
    rows.append(at_most("single effects: wrong name or no answer", wrong, len(some), 3, 150))
    right = [len(each["named"]) for each in some if each["outcome"] in RIGHT]
    if right:
        mean = float(np.mean(right))
        rows.append(must_show("names of a right answer, mean", mean, NAMES, mean <= NAMES))
    return rows


def sound(done: Cases) -> list[Row]:
    """Hands that lack nothing."""
    some = _of(done, "sound")
    if not some:
        return []
    called = ended_or_late(some, "named", "called")
    return [
        at_most("sound: named", sum(c["outcome"] == "named" for c in some), len(some), 1, 120),
        at_most("sound: anything but silent", called, len(some), 5, 120),
    ]


def several(done: Cases) -> list[Row]:
    """Pairs and triples."""
    rows, pairs, triples = [], _of(done, "pair"), _of(done, "triple")
    if pairs:
        wrong = ended_or_late(pairs, "wrong")
        rows.append(at_least("pairs: both named", ended(pairs, "both"), len(pairs), 21, 30))
        rows.append(at_most("pairs: any wrong name or no answer", wrong, len(pairs), 1, 30))
    if triples:
        good = ended(triples, "all", "two")
        rows.append(at_least("triples: two or more named, none wrong", good, len(triples), 8, 12))
    return rows


def faults(done: Cases) -> list[Row]:
    """Faults of one finger."""
    some = _of(done, "fault")
    if not some:
        return []
    right = [len(c["named"]) for c in some if c["outcome"] in RIGHT]
    rows = [
        at_least("faults: kind, finger or a class of them", ended(some, *RIGHT), len(some), 19, 24)
    ]
    if right:
        mean = float(np.mean(right))
        rows.append(must_show("fingers of that class, mean", mean, FINGERS, mean <= FINGERS))
    return rows


def outside(done: Cases) -> list[Row]:
    """Kinds that no catalogue has: names, and what the description closes on other commands."""
    some = _of(done, *OUTSIDE)
    if not some:
        return []
    shares = [each["elsewhere"] for each in some]
    median = float(np.median(shares))
    kinds = len({name for each in some for name in each["effects"]})
    row = must_show("the same: gap closed on another command, median", median, CLOSES,
                    median >= CLOSES)  # fmt: skip
    wrong = ended_or_late(some, "wrong")
    return [
        at_most(f"outside the catalogue, {kinds} kinds: a name or no answer", wrong,
                len(some), 4, 40),
        {**row, **interval(shares)},
    ]  # fmt: skip


def mujoco(done: Cases) -> list[Row]:
    """Hands in MuJoCo's own laws of contact, wire and dry friction."""
    rows, sound, hiding = [], _of(done, "MuJoCo sound"), _of(done, "MuJoCo slack", "MuJoCo load")
    if sound:
        wrong = ended_or_late(sound, "wrong")
        rows.append(
            at_most("MuJoCo, sound: a name that is no law it has otherwise", wrong,
                    len(sound), 1, 12)
        )  # fmt: skip
    if hiding:
        missed = len(hiding) - ended(hiding, *RIGHT)
        rows.append(at_most("MuJoCo, slack or load: missed or wrong", missed, len(hiding), 4, 12))
    return rows


def sizes(done: Cases) -> list[Row]:
    """Errors of named sizes, and how many intervals hold the truth."""
    some = _of(done, "single", "pair", "triple")
    found = [each for case in some for each in case["parameters"].values()]
    if not found:
        return []
    errors, covers = [e["error"] for e in found], float(np.mean([e["covers"] for e in found]))
    error, (low, high) = float(np.median(errors)), COVERS
    row = must_show("error of a named size, median", error, ERROR, error <= ERROR)
    bound = low if covers < low else high
    return [
        {**row, **interval(errors)},
        must_show("coverage of 95 % intervals", covers, bound, low <= covers <= high),
    ]


def missing(done: Cases) -> list[Row]:
    """What is hidden and what was said instead, a line for each case that went otherwise."""
    good = ("right", "class", "silent", "both", "all", "two", "law")
    return [
        {
            "kind": case["kind"],
            "seed": case["seed"],
            "hidden": " + ".join(case["effects"]) or "nothing",
            "outcome": "late" if late(case) else case["outcome"],
            "said": " ".join([case["verdict"], *case["named"]]),
        }
        for case in done
        if "outcome" in case and case["what"] not in OUTSIDE
        if case["outcome"] not in good or (case["effects"] and case["outcome"] == "silent")
    ]


def _of(done: Cases, *what: str) -> list[Case]:
    return [each for each in done if each["what"] in what]


def _row(name: str, cases: Cases) -> Row:
    made = [case for case in cases if "outcome" in case]
    seconds = [case["processor_seconds"] for case in made]
    return {
        "kind": name,
        "cases": len(cases),
        "not made": len(cases) - len(made),
        "late": sum(map(late, made)),
        **dict(sorted(Counter(case["outcome"] for case in made).items())),
        "processor_s": float(np.median(seconds)) if seconds else float("nan"),
    }
