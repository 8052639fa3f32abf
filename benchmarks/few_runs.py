"""Calibration by a first hour's recordings: 1 to 3 conditions of 2 to 5 runs.

A third of the campaigns is sound, a third lacks an effect, a third has a logger's fault in it. The
independent truth (benchmarks/truth) makes them, of hands whose every value is 1.5 % off and each
joint 0.75 % for itself. Settings are the defaults, and a third of the users state nothing. Nothing
was tuned on these seeds: development had others, all below 1,000. Some ten seconds a case, which
--resume spreads over as many calls as it takes.
"""

import argparse
from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.few.cases import case
from benchmarks.few.outcome import outcome
from benchmarks.few.summary import figures
from benchmarks.harness import given

CASES = Path("results/benchmarks/few_runs.jsonl")
FIRST, COUNTS = 100_000, (400, 3)  # whole, quick
CODE = ("hannes", "benchmarks.truth", "benchmarks.few")  # what a case comes from


def measured(kind: str, seed: int) -> dict[str, Any]:
    """One case, and the code that it was had with."""
    return {"code": study.code(*CODE), **outcome(case(seed), seed)}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.few_runs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="three cases, for a first look")
    parser.add_argument("--resume", action="store_true", help="keep the cases already measured")
    parser.add_argument("--first", type=int, default=FIRST, help=f"first seed ({FIRST})")
    parser.add_argument("--count", type=int, help=f"number of cases ({COUNTS[0]})")
    parser.add_argument("--cases", type=Path, default=CASES, metavar="FILE",
                        help=f"a line for each case ({CASES})")  # fmt: skip
    parser.add_argument("--json", metavar="FILE", help="write rows as JSON; - for standard output")
    return parser.parse_args()


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    asked = _arguments()
    count = asked.count or COUNTS[asked.quick]
    cases = [("few", asked.first + k) for k in range(count)]
    done = study.run(asked.cases, cases, measured, asked.resume)
    rows, shown = figures(done)
    given({"rows": rows, "must_show": shown}, (rows, shown), asked.json)


if __name__ == "__main__":
    main()
