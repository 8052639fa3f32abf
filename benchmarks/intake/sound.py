"""Sound logs of every kind that a lab writes: none of them may be called faulty."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.intake.bases import MACHINES, Logger, base, count, logged
from benchmarks.intake.case import plant_of
from benchmarks.intake.log import Log
from benchmarks.intake.mapped import recordings, sound_mapping
from hannes.campaigns.check import check

SLOWEST, FASTEST = 40.0, 20_000.0  # Hz
MOST_ROWS = 40_000


def case(seed: int) -> dict[str, Any]:
    """One sound log, and the faults and warnings that `check` gives of it."""
    rng = np.random.default_rng([seed, 5])
    machine = str(rng.choice(MACHINES))
    run = base(machine, int(rng.integers(count(machine))))
    lasting = float(run.channels["time"][-1])
    rate = float(np.exp(rng.uniform(np.log(SLOWEST), np.log(min(FASTEST, MOST_ROWS / lasting)))))
    logger = Logger(
        rate,
        noise=float(rng.uniform(0.0, 2.0)),
        step=float(rng.choice([1.0, 2.0, 4.0])),
        jitter=float(rng.choice([0.0, 0.05, 0.2])),
        bits=int(rng.choice([0, 0, 8, 10, 12, 16])),
    )
    log = logged(run, logger, bool(rng.random() < 0.6) or machine == "axis", rng)
    log = _with_gaps(log, rng) if rng.random() < 0.3 else log
    with tempfile.TemporaryDirectory() as folder:
        (made,) = recordings(run, log, sound_mapping(run, log), Path(folder))
    found = check(made.recording, plant_of(machine))
    return {
        "machine": machine, "run": run.number, "rate": round(rate, 1), "bits": logger.bits,
        "jitter": logger.jitter, "rows": len(log.time),
        "faults": [str(each) for each in found if each.level == "fault"],
        "warnings": [str(each) for each in found if each.level == "warning"],
    }  # fmt: skip


def _with_gaps(log: Log, rng: np.random.Generator) -> Log:
    """Without some rows here and there, with true stamps on the others."""
    kept = np.ones(log.time.size, np.bool_)
    for _ in range(int(rng.integers(1, 5))):
        start = int(rng.integers(1, log.time.size - 1))
        kept[start : start + 1 + int(rng.integers(0, max(log.time.size // 50, 1)))] = False
    kept[0] = kept[-1] = True
    return log.rows(kept)
