"""One case: campaign made, answer moved out of reach, diagnosis, verdict on disk, answer opened."""

import json
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.naming_study.closed import left
from benchmarks.naming_study.draw import Drawn
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.protocol import Protocol
from hannes.commands.diagnose import Diagnosis
from hannes.commands.diagnose import diagnose as library
from hannes.core.errors import ComputationFailed

Diagnose = Callable[[Path, Path], Diagnosis | None]  # campaign file, folder for verdict.json


def diagnosed(campaign: Path, out: Path) -> Diagnosis:
    """What a user gets who types `hannes diagnose`."""
    return library(campaign, out=out, progress=False)


def run_case(
    case: Drawn,
    plan: Protocol,
    seed: int,
    assumed_ratio: float = 1.0,
    diagnose: Diagnose | None = None,
) -> dict[str, Any]:
    """Verdict and answer of a case, and what the diagnosis took.

    assumed_ratio: the scatter that the analyst assumes over the true one. diagnose: in place of
    the library's.
    """
    with tempfile.TemporaryDirectory() as folder:
        open_part, sealed = Path(folder) / "campaign", Path(folder) / "elsewhere"
        try:
            made = make(plan, seed, case.hidden, assumed=Spread().times(assumed_ratio))
        except ComputationFailed as failed:
            return {"not_made": str(failed)}
        made.write(open_part)
        shutil.move(open_part / "sealed", sealed)
        begun, spent, found = time.perf_counter(), time.process_time(), None
        try:
            found = (diagnose or diagnosed)(open_part / "campaign.toml", open_part / "out")
        except ComputationFailed as failed:
            (open_part / "out").mkdir(exist_ok=True)
            verdict = {"verdict": "failed", "effects": [], "reason": str(failed)}
            (open_part / "out" / "verdict.json").write_text(json.dumps(verdict), encoding="utf-8")
        took = {
            "seconds": time.perf_counter() - begun,
            "processor_seconds": time.process_time() - spent,
        }
        verdict = _read(open_part / "out" / "verdict.json")
        answer = _read(sealed / "answer.json")["effects"]
        gap = _left(found, case, plan, seed) if found else None
        return {"verdict": verdict, "answer": answer, "left": gap, **took}


def _left(found: Diagnosis, case: Drawn, plan: Protocol, seed: int) -> dict[str, float] | None:
    """Reducible gap before and after, where something is hidden and something named."""
    if found.details is None or not (case.effects and found.verdict.effects):
        return None
    try:
        gap = left(found.campaign, found.details, case, plan, seed)
    except (RuntimeError, ComputationFailed, np.linalg.LinAlgError):  # a run of it does not end
        return None
    return gap if np.isfinite(list(gap.values())).all() else None


def _read(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))
