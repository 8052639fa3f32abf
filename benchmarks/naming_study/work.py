"""One case: campaign made, answer moved out of reach, diagnosis, verdict on disk, answer opened."""

import json
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.naming_study.draw import Drawn
from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.protocol import Protocol
from hannes.diagnose import diagnose as library
from hannes.errors import ComputationFailed

Diagnose = Callable[[Path, Path], None]  # campaign file, folder for verdict.json


def diagnosed(campaign: Path, out: Path) -> None:
    """What a user gets who types `hannes diagnose`."""
    library(campaign, out=out, progress=False)


def worked(
    case: Drawn, plan: Protocol, seed: int, told: float = 1.0, diagnose: Diagnose | None = None
) -> dict[str, Any]:
    """Verdict and answer of a case, and what the diagnosis took.

    told: how many times as wide as it is the analyst is told that the scatter is. diagnose: in
    place of the library's.
    """
    with tempfile.TemporaryDirectory() as folder:
        open_part, sealed = Path(folder) / "campaign", Path(folder) / "elsewhere"
        try:
            made = make(plan, seed, case.hidden, told=Spread().times(told))
        except ComputationFailed as failed:
            return {"not_made": str(failed)}
        made.write(open_part)
        shutil.move(open_part / "sealed", sealed)
        begun, spent = time.perf_counter(), time.process_time()
        try:
            (diagnose or diagnosed)(open_part / "campaign.toml", open_part / "out")
        except ComputationFailed as failed:
            (open_part / "out").mkdir(exist_ok=True)
            verdict = {"verdict": "failed", "effects": [], "reason": str(failed)}
            (open_part / "out" / "verdict.json").write_text(json.dumps(verdict), encoding="utf-8")
        took = {
            "seconds": time.perf_counter() - begun,
            "processor_seconds": time.process_time() - spent,
        }
        verdict = _read(open_part / "out" / "verdict.json")
        return {"verdict": verdict, "answer": _read(sealed / "answer.json")["effects"], **took}


def _read(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))
