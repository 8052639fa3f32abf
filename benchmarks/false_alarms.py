"""How often a hand that lacks nothing is given a name: two thousand sound campaigns.

Hands, joints (each 1 % off for itself) and runs scatter as those of the naming study do, about the
linearisation of the independent truth (benchmarks/linearised); a quarter have coloured noise of the
current. The diagnosis is the library's, whole, on a plant whose runs are sums of the truth's
columns: simulation costs nothing. What is not linear is not tested here; nothing samples, and
rounding is noise. Effects of the catalogue are all tried, but a delay of the measurement.
Columns are simulated once, in a minute; the whole takes some 50 minutes of a core, which --resume
spreads over several calls.
"""

import json
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import study
from benchmarks.harness import Row, given, must_show
from benchmarks.linearised.campaign import write
from benchmarks.naming_study.apart.draw import BANDWIDTHS
from benchmarks.naming_study.apart.score import sound
from hannes.commands.diagnose import diagnose
from hannes.core.errors import HannesError

FOLDER = Path("results/benchmarks")
RECORDS = Path(__file__).parent / "records"
SETS = {"development": 420_000_000, "quoted": 430_000_000}  # first seeds
COUNT, QUICK = 2000, 2
MOST = 0.005  # share that is given a name
COLOURED = 4  # one in so many
CODE = ("hannes", "benchmarks.truth", "benchmarks.linearised")


def measured(kind: str, seed: int) -> dict[str, Any]:
    """A campaign's verdict."""
    bandwidth = bandwidth_of(kind, seed)
    row: dict[str, Any] = {"code": study.code(*CODE), "bandwidth_hz": bandwidth}
    with tempfile.TemporaryDirectory() as folder:
        campaign = write(seed, bandwidth, Path(folder))
        spent = time.process_time()
        try:
            verdict = json.loads(diagnose(campaign, trust=True, progress=False).verdict.json())
        except HannesError as failed:
            verdict = {"verdict": "failed", "effects": [], "reason": str(failed)}
    return {
        **row,
        "outcome": sound(verdict),
        "verdict": verdict["verdict"],
        "named": verdict["effects"],
        "reason": verdict["reason"],
        "processor_seconds": time.process_time() - spent,
    }


def bandwidth_of(kind: str, seed: int) -> float | None:
    """Of the noise (Hz), log-uniform; None where it is white."""
    low, high = BANDWIDTHS
    share = np.random.default_rng([seed, 55]).uniform()
    return float(low * (high / low) ** share) if kind == "coloured noise" else None


def cases(first: int, count: int) -> list[study.Case]:
    """Kind and seed of each campaign."""
    kinds = ("coloured noise", *("white noise",) * (COLOURED - 1))
    return [(kinds[k % COLOURED], first + k) for k in range(count)]


def figures(done: list[dict[str, Any]]) -> tuple[list[Row], list[Row]]:
    """Counts of each kind, and what must be shown."""
    rows = []
    for kind in sorted({each["kind"] for each in done}):
        some = [each for each in done if each["kind"] == kind]
        seconds = float(np.median([each["processor_seconds"] for each in some]))
        counts = Counter(each["outcome"] for each in some)
        rows.append({"noise": kind, "cases": len(some), **counts, "processor_s": seconds})
    named = sum(each["outcome"] == "named" for each in done)
    share = named / len(done) if done else 0.0
    return rows, [must_show(f"sound, named, share of {len(done)}", share, MOST, share <= MOST)]


def main() -> None:
    """Measure, print tables, write JSON where asked."""
    parser = study.parser("false_alarms", __doc__)
    parser.add_argument("--set", choices=SETS, default="development", dest="chosen",
                        help="of seeds (development)")  # fmt: skip
    asked = parser.parse_args()
    home = RECORDS if asked.chosen == "quoted" and not asked.quick else FOLDER
    file = asked.cases or home / f"false-alarms-{asked.chosen}{'-quick' * asked.quick}.jsonl"
    wanted = cases(SETS[asked.chosen], QUICK if asked.quick else COUNT)[: asked.most]
    done = (
        list(study.read(file))
        if asked.show
        else study.run(file, wanted, measured, asked.resume or home == RECORDS, asked.workers)
    )
    rows, bounds = figures(done)
    given({"rows": rows, "must_show": bounds}, (rows, bounds), asked.json)


if __name__ == "__main__":
    main()
