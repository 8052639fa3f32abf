"""The naming study of a geared servo: `python -m benchmarks.naming --machine servo`.

Servos and what is hidden in them come from the truth (benchmarks/truth/geared_servo.py), the
diagnosis is that of examples/servo. 60 cases have an effect or two, 20 are sound. Right is exactly
what is hidden, with a remainder or without; a class counts where what is hidden is in it.
"""

import json
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.harness import Row, must_show
from benchmarks.naming_study import servo_bench
from benchmarks.naming_study.choice import Study
from benchmarks.naming_study.score import CLAIMS
from benchmarks.naming_study.servo_draw import RANGES, drawn
from hannes.commands.diagnose import diagnose
from hannes.core.errors import ComputationFailed

SETS = {"development": 0, "quoted": 5_000}  # first seeds; development's are below 1000
APART = 100  # seeds between kinds
COUNTS: Mapping[str, int] = {**dict.fromkeys(sorted(RANGES), 7), "pair": 11, "sound": 20}
QUICK = {"gear_load": 1, "sound": 1}
ABSENT = ("no_gap", "recalibrated")
LEAST_RIGHT, MOST_WRONG, MOST_CALLED = 54, 2, 1
CODE = ("hannes", "benchmarks.truth", "benchmarks.naming_study")


def cases(chosen: str, quick: bool) -> list[study.Case]:
    """Kind and seed of every case of a set; kinds take turns."""
    counts = QUICK if quick else COUNTS
    found = [
        ((k + 0.5) / count, (kind, SETS[chosen] + APART * number + k))
        for number, (kind, count) in enumerate(counts.items())
        for k in range(count)
    ]
    return [case for _, case in sorted(found)]


def measured(kind: str, seed: int) -> dict[str, Any]:
    """One case: made, diagnosed, scored."""
    hidden = drawn(kind, seed)
    with tempfile.TemporaryDirectory() as folder:
        campaign = servo_bench.make(Path(folder) / "campaign", seed, hidden.values)
        spent = time.process_time()
        try:
            found = diagnose(campaign, trust=True, progress=False).verdict
            verdict = json.loads(found.json())
        except ComputationFailed as failed:
            verdict = {"verdict": "failed", "effects": [], "reason": str(failed)}
        spent = time.process_time() - spent
    named = [name.rpartition(":")[2] for name in verdict["effects"]]
    return {
        "code": study.code(*CODE), "effects": hidden.effects, "hidden": dict(hidden.values),
        "verdict": verdict["verdict"], "named": named, "reason": verdict["reason"],
        "outcome": outcome(hidden.effects, verdict["verdict"], named),
        "processor_seconds": spent,
    }  # fmt: skip


def outcome(hidden: Sequence[str], said: str, named: Sequence[str]) -> str:
    """How a verdict counts: right, class, part, wrong, unknown or silent; sound or called."""
    if not hidden:
        return "sound" if said in ABSENT else "called"
    if said not in CLAIMS:
        return "unknown" if said == "unknown" else "silent"
    if said == "one_of":
        return "class" if set(hidden) & set(named) else "wrong"
    if set(named) - set(hidden):
        return "wrong"
    return "right" if set(named) == set(hidden) else "part"


def figures(done: Iterable[Mapping[str, Any]]) -> tuple[list[Row], list[Row]]:
    """A row a kind, and what must be shown of all."""
    kinds: dict[str, list[Mapping[str, Any]]] = {}
    for case in done:
        kinds.setdefault(case["kind"], []).append(case)
    rows = [
        {"hidden": kind, "cases": len(each), **Counter(case["outcome"] for case in each)}
        for kind, each in sorted(kinds.items())
    ]
    every = Counter(case["outcome"] for each in kinds.values() for case in each)
    count = sum(len(each) for kind, each in kinds.items() if kind != "sound")
    right, least = every["right"] + every["class"], LEAST_RIGHT / 60.0 * count
    called = every["called"]
    return rows, [
        must_show(f"servo: right or a class with it, of {count}", right, least, right >= least),
        must_show("servo: wrong", every["wrong"], MOST_WRONG, every["wrong"] <= MOST_WRONG),
        must_show("servo: sound, called missing", called, MOST_CALLED, called <= MOST_CALLED),
    ]


def named(chosen: str, quick: bool) -> str:
    """Of the file of a set."""
    return f"naming-servo-{chosen}{'-quick' if quick else ''}"


def tables(done: list[dict[str, Any]]) -> tuple[dict[str, Any], Sequence[Sequence[Row]]]:
    """What was found, and its tables."""
    rows, bounds = figures(done)
    return {"rows": rows, "must_show": bounds}, (rows, bounds)


STUDY = Study(SETS, tuple(COUNTS), cases, measured, named, tables)
