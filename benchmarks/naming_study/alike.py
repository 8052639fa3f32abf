"""The former study: fingers alike, half to five times u, users who state their scatter.

All nominal values scatter by 2 %, runs by 0.5 % and 0.2 ms. The poor protocol has six void and six
dynamometer runs at the paper's command. The rich one has sixteen runs with duty and bus voltage. An
abstention counts as a case like any other, and as 0 % of the gap closed. Where the poor protocol
leaves a class or an unknown, one more run is made: the proposed one, with the channels that it asks
for. A random run of the rich protocol is compared with it, once logged as the others are and once
with those channels.
"""

from collections.abc import Sequence
from typing import Any

from benchmarks import study
from benchmarks.harness import Row
from benchmarks.naming_study import frozen, summary
from benchmarks.naming_study.choice import Study
from benchmarks.naming_study.draw import PLANS, Drawn, any_run, drawn, with_run
from benchmarks.naming_study.plan import NAMED, SETS, cases
from benchmarks.naming_study.score import scores, single
from benchmarks.naming_study.work import run_case

FOLLOWED = "single, poor"  # the kind whose open cases get one more run
CODE = ("hannes", "benchmarks.truth", "benchmarks.naming_study")  # what a case comes from


def measured(name: str, seed: int) -> dict[str, Any]:
    """One case, and the code that measured it."""
    return {"code": study.code(*CODE), **_measured(name, seed)}


def _measured(name: str, seed: int) -> dict[str, Any]:
    """Drawn, made, diagnosed, scored."""
    kind = NAMED[name]
    case = drawn(kind.what, kind.protocol, seed)
    fields = {
        "what": kind.what,
        "protocol": kind.protocol,
        "assumed_ratio": kind.assumed_ratio,
        "effects": case.effects,
        "hidden": case.hidden,
        "times": case.least_times,
    }
    found = run_case(case, PLANS[kind.protocol], seed, kind.assumed_ratio)
    if "not_made" in found:
        return {**fields, **found}
    time = {key: found[key] for key in ("seconds", "processor_seconds")}
    scored = scores(kind.what, found, case.effects)
    after = one_more(case, seed, found["verdict"]) if name == FOLLOWED else {}
    return {**fields, **scored, **time, "after": after}


def one_more(case: Drawn, seed: int, verdict: dict[str, Any]) -> dict[str, str]:
    """Outcome after the proposed run and after any run, where the verdict left the case open.

    Where the proposal asks for more channels, any run is recorded with them too ("same_channels").
    """
    if verdict["verdict"] not in ("one_of", "unknown") or not verdict.get("next_run"):
        return {}
    run, also = verdict["next_run"]["experiment"], verdict["next_run"]["also_log"]
    runs = {"suggested": (run, also), "any": (any_run(seed), ())}
    runs |= {"same_channels": (any_run(seed), also)} if also else {}
    ends = {}
    for end, more in runs.items():
        found = run_case(case, with_run(PLANS["poor"], *more), seed)
        ends[end] = found.get("not_made") or single(found["verdict"], case.effects[0])
    return ends


def named(chosen: str, quick: bool) -> str:
    """Of the file: one for each set of seeds and frozen file of sizes."""
    million = SETS[chosen] // 1_000_000
    return f"naming-{chosen}-{million}-million{'-quick' if quick else ''}-{frozen.digest()}"


def tables(done: list[dict[str, Any]]) -> tuple[dict[str, Any], Sequence[Sequence[Row]]]:
    """What was found, and its tables."""
    rows, bounds = summary.figures(done)
    confusion = summary.confusion(done)
    found = {"rows": rows, "must_show": bounds, "confusion": confusion}
    return found, (rows, summary.confusion_rows(confusion), bounds)


STUDY = Study(SETS, tuple(NAMED), cases, measured, named, tables)
