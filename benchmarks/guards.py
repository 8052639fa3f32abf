"""No wrong answer from a hand whose fingers differ, or from a user who states nothing.

Thirty campaigns of the independent truth (benchmarks/truth), six free closures and six grasps each.
Every joint is 1 % off for itself, as no model of the library is. Seventeen hide an effect of a
tenth of its range up to its end; ten are of users who state no scatter and name the shipped
experiments, whose controller is continuous where the hand's is sampled.

Every result is simulated beside runs made anew. Counted are gaps that refitting or naming raises
there by more than runs differ by (one-sided 1 %, over all channels together), and campaigns
without an answer within 120 s of processor time. Printed too: names, and how many sound hands are
called missing something.

The whole takes an hour, which --resume spreads over several calls; --quick has one case. The
quoted set has seeds that nothing was developed on.
"""

from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.guarding.plan import KINDS, SETS, cases
from benchmarks.guarding.work import measured
from benchmarks.harness import Row, given, must_show

FOLDER = Path("results/benchmarks")
RECORDS = Path(__file__).parent / "records"
SECONDS = 120.0  # of a processor, for one answer
MISSING = ("named", "one_of", "named_with_remainder", "unknown")


def figures(done: list[dict[str, Any]]) -> tuple[list[Row], list[Row]]:
    """A row for each kind, and what must be shown."""
    made = [each for each in done if "not_made" not in each]
    rows = [_row(kind.name, [each for each in made if each["kind"] == kind.name]) for kind in KINDS]
    late = [e for e in made if e.get("processor_seconds", SECONDS + 1.0) > SECONDS]
    worse = [each for each in made if each.get("worse")]
    bounds = [
        must_show("campaigns where something taken raises a gap", len(worse), 0, not worse),
        must_show("campaigns without an answer in time", len(late), 0, not late),
    ]
    return [row for row in rows if row["cases"]], bounds


def _row(name: str, some: list[dict[str, Any]]) -> Row:
    right = [e for e in some if e.get("named") and set(e["named"]) == _effects(e)]
    classes = [e for e in some if e["verdict"] == "one_of" and _effects(e) & set(e["named"])]
    wrong = [e for e in some if set(e.get("named", ())) - _effects(e) and e not in classes]
    seconds = [each.get("processor_seconds", 0.0) for each in some]
    return {
        "campaigns": name,
        "cases": len(some),
        "right_name": len(right),
        "class_with_it": len(classes),
        "wrong_name": len(wrong),
        "unknown": sum(each["verdict"] == "unknown" for each in some),
        "called_missing": sum(each["verdict"] in MISSING for each in some),
        "worse": sum(bool(each.get("worse")) for each in some),
        "longest_s": max(seconds, default=0.0),
    }


def _effects(case: dict[str, Any]) -> set[str]:
    return {name.partition(".")[0] for name in case["hidden"]}


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    parser = study.parser("guards", __doc__)
    parser.add_argument("--set", choices=SETS, default="development", dest="chosen",
                        help="of seeds (development)")  # fmt: skip
    asked = parser.parse_args()
    home = RECORDS if asked.chosen == "quoted" and not asked.quick else FOLDER
    file = asked.cases or home / f"guards-{asked.chosen}{'-quick' * asked.quick}.jsonl"
    if asked.show:
        done = list(study.read(file))
    else:
        wanted = cases(asked.chosen, asked.quick)[: asked.most]
        done = study.run(file, wanted, measured, asked.resume or home == RECORDS, asked.workers)
    rows, bounds = figures(done)
    given({"rows": rows, "must_show": bounds}, (rows, bounds), asked.json)


if __name__ == "__main__":
    main()
