"""Calibration by a first hour's recordings: 1 to 3 conditions of 2 to 5 runs.

A third of the campaigns is sound, a third lacks an effect, a third has a logger's fault in it. The
independent truth (benchmarks/truth) makes them, of hands whose every value is 1.5 % off and each
joint 0.75 % for itself. Settings are the defaults, and a third of the users state nothing. Nothing
was tuned on these seeds: development had others, all below 1,000. Some ten seconds a case, which
--resume spreads over as many calls as it takes.
"""

from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.few.cases import case
from benchmarks.few.outcome import outcome
from benchmarks.few.summary import figures
from benchmarks.harness import given

CASES = Path("results/benchmarks/few_runs.jsonl")
FIRST, COUNTS = 200_000, (400, 3)  # whole, quick; those from 100,000 on were looked at in part
CODE = ("hannes", "benchmarks.truth", "benchmarks.few")  # what a case comes from


def measured(kind: str, seed: int) -> dict[str, Any]:
    """One case, and the code that it was had with."""
    return {"code": study.code(*CODE), **outcome(case(seed), seed)}


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    parser = study.parser("few_runs", __doc__)
    parser.add_argument("--first", type=int, default=FIRST, help=f"first seed ({FIRST})")
    asked = parser.parse_args()
    file, count = asked.cases or CASES, COUNTS[asked.quick]
    if asked.show:
        done = list(study.read(file))
    else:
        wanted = [("few", asked.first + k) for k in range(count)][: asked.most]
        done = study.run(file, wanted, measured, asked.resume, asked.workers)
    rows, shown = figures(done)
    given({"rows": rows, "must_show": shown}, (rows, shown), asked.json)


if __name__ == "__main__":
    main()
