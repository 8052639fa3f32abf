"""Naming of effects hidden by the independent truth: right, class, wrong, silent, unknown.

Hands, effects and firmware come from the second implementation (benchmarks/truth). All nominal
values scatter by 2 %, runs by 0.5 % and 0.2 ms. Sizes are half to five times u, the minimum
detectable size of a likelihood-ratio test that knows the effect (80 % power, 5 % false alarms),
frozen in benchmarks/oracle/smallest_detectable.toml. The poor protocol has six void and six
dynamometer runs at the paper's command. The rich one has sixteen runs with duty and bus voltage. An
answer is out of reach until the verdict is on disk.

The method was developed on the seeds of the set "development". The quoted figures are of the set
"quoted". An abstention counts as a case like any other, and as 0 % of the gap closed. Where the
poor protocol leaves a class or an unknown, one more run is made: the proposed one, with the
channels that it asks for. A random run of the rich protocol is compared with it, once logged as
the others are and once with those channels.

The whole study takes hours, which --resume spreads over several calls. Cases of all kinds take
turns, so --show has cases of all kinds at any time. Results of the quoted set are in
benchmarks/records. --quick takes some minutes. Times need an otherwise idle machine: --workers 1.

--machine servo is the study of the geared servo of examples/servo: 80 cases, see
benchmarks/naming_study/servo_study.py.
"""

import argparse
import sys
from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.harness import given
from benchmarks.naming_study import frozen, records, servo_study, summary
from benchmarks.naming_study.draw import PLANS, Drawn, any_run, drawn, with_run
from benchmarks.naming_study.plan import NAMED, SETS, cases
from benchmarks.naming_study.score import scores, single
from benchmarks.naming_study.work import run_case

FOLDER = Path("results/benchmarks")
RECORDS = Path(__file__).parent / "records"  # of the quoted set: hours of work, part of the project
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


def kept(chosen: str, quick: bool) -> Path:
    """The file with a line for each case: one for each set of seeds and frozen file of sizes."""
    folder = RECORDS if chosen == "quoted" and not quick else FOLDER
    name = f"naming-{chosen}-{SETS[chosen] // 1_000_000}-million"
    return folder / f"{name}{'-quick' if quick else ''}-{frozen.digest()}.jsonl"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.naming",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="few cases, for a first look")
    parser.add_argument(
        "--resume",
        action="store_true",
        help="keep the cases already measured, as the quoted set always does",
    )
    parser.add_argument("--show", action="store_true",
                        help="measure nothing: tables of the cases already measured")  # fmt: skip
    parser.add_argument("--set", choices=SETS, default="development", dest="chosen",
                        help="of seeds (development)")  # fmt: skip
    parser.add_argument("--only", choices=NAMED, metavar="KIND",
                        help=f"one kind alone: {'; '.join(NAMED)}")  # fmt: skip
    parser.add_argument("--machine", choices=("hand", "servo"), default="hand", help="(hand)")
    parser.add_argument("--workers", type=int, default=1, help="processes (1)")
    parser.add_argument("--cases", type=Path, metavar="FILE", help="a line for each case")
    parser.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    return parser.parse_args()


def servo(asked: argparse.Namespace) -> None:
    """The study of the servo: measure, print tables, write JSON where asked."""
    ending = "-quick" if asked.quick else ""
    folder = RECORDS if asked.chosen == "quoted" and not asked.quick else FOLDER
    file = asked.cases or folder / f"naming-servo-{asked.chosen}{ending}.jsonl"
    if asked.show:
        done = list(records.read(file))
    else:
        resume = asked.resume or folder == RECORDS
        wanted = servo_study.cases(asked.chosen, asked.quick)
        done = records.run(file, wanted, servo_study.measured, resume, asked.workers)
    rows, bounds = servo_study.figures(done)
    given({"cases": file.name, "rows": rows, "must_show": bounds}, (rows, bounds), asked.json)


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    asked = _arguments()
    if asked.machine == "servo":
        servo(asked)
        return
    file = asked.cases or kept(asked.chosen, asked.quick)
    if asked.show:
        # As they were measured, with --cases of any set.
        done = [row for row in records.read(file) if asked.only in (None, row["kind"])]
    else:
        wanted = [c for c in cases(asked.chosen, asked.quick) if asked.only in (None, c[0])]
        resume = asked.resume or file.parent == RECORDS
        done = records.run(file, wanted, measured, resume, asked.workers)
    if len({case.get("code") for case in done}) > 1:
        print("not all cases are of the same code; --resume kept them", file=sys.stderr)
    rows, bounds = summary.figures(done)
    confusion = summary.confusion(done)
    found = {"cases": file.name, "rows": rows, "must_show": bounds, "confusion": confusion}
    given(found, (rows, summary.confusion_rows(confusion), bounds), asked.json)


if __name__ == "__main__":
    main()
