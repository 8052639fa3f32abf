"""One case: recordings made, the answer out of reach, diagnosed, scored."""

import json
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks import study
from benchmarks.described import NOTHING, described
from benchmarks.naming_study.apart.bench import OTHER, OUTSIDE, Case, case, written
from benchmarks.naming_study.apart.kinds import NAMED, Kind
from benchmarks.naming_study.apart.parting import PARTED, parted
from benchmarks.naming_study.apart.score import scores
from hannes.commands.diagnose import Diagnosis, diagnose
from hannes.core.errors import HannesError

CODE = ("hannes", "benchmarks.truth", "benchmarks.naming_study", "benchmarks.oracle")
Diagnose = Callable[[Path], Diagnosis]


def diagnosed(campaign: Path) -> Diagnosis:
    """What a user gets who types `hannes diagnose`."""
    return diagnose(campaign, progress=False)


def measured(name: str, seed: int, ask: Diagnose = diagnosed) -> dict[str, Any]:
    """A line of the study. ask: in place of the library's diagnosis."""
    kind = NAMED[name]
    row: dict[str, Any] = {"code": study.code(*CODE), "what": kind.what, "protocol": kind.protocol}
    try:
        one = case(kind, seed)
    except HannesError as failed:
        return {**row, "not_made": str(failed)}
    hidden = one.hidden
    row |= {
        "effects": hidden.effects,
        "hidden": hidden.sizes,
        "times": hidden.times,
        "fault": vars(hidden.fault) if hidden.fault else None,
        "bandwidth_hz": hidden.bandwidth,
        "shows": one.shows,
    }
    verdict, found, seconds = answered(one, kind.stated, ask)
    scored = scores(kind.what, verdict, hidden.effects, hidden.sizes, hidden.fault)
    row |= {**scored, "processor_seconds": seconds}
    return {**row, **_fingers(kind, seed, one, row), **_elsewhere(kind, one, found)}


def answered(
    one: Case, stated: bool, ask: Diagnose
) -> tuple[Mapping[str, Any], Diagnosis | None, float]:
    """The verdict as its file has it, all of the diagnosis, and processor time (s)."""
    with tempfile.TemporaryDirectory() as folder:
        campaign = written(one.made, stated, Path(folder))
        spent = time.process_time()
        try:
            found = ask(campaign)
        except HannesError as failed:
            verdict = {"verdict": "failed", "effects": [], "reason": str(failed)}
            return verdict, None, time.process_time() - spent
        return json.loads(found.verdict.json()), found, time.process_time() - spent


def _fingers(kind: Kind, seed: int, one: Case, row: Mapping[str, Any]) -> dict[str, Any]:
    """Of a class of fingers: what parts each from the true one; "wide" where that is too much."""
    true = one.hidden.fault
    if true is None or row["outcome"] != "class":
        return {}
    others = [name.partition("_")[0] for name in row["named"]]
    others = [finger for finger in others if finger != true.finger]
    chi2 = parted("rich" if kind.protocol == "rich" else "poor", seed, true, others)
    wide = any(each >= PARTED for each in chi2.values())
    return {"parted": chi2, "outcome": "wide" if wide else "class"}


def _elsewhere(kind: Kind, one: Case, found: Diagnosis | None) -> dict[str, Any]:
    """What a description closes of the gap under commands that were not given."""
    if kind.what not in OUTSIDE:
        return {}
    if found is None or found.details is None:
        return {"shape": NOTHING["shape"], "elsewhere": NOTHING["elsewhere"], "by_command": {}}
    row = described(found, one.made, OTHER)
    kept = ("shape", "closes", "why_not", "elsewhere", "by_command")
    return {**{key: row[key] for key in kept}, "shows_elsewhere": row["shows"]}
