"""One case of `guards`: recordings made, diagnosed, the result held against runs made anew."""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.guarding.plan import AGAIN, NAMED, SHIPPED, SPREAD, hidden, plan
from benchmarks.truth.campaign import Made, make
from hannes.campaigns.campaign import Entry
from hannes.campaigns.segments import Segment
from hannes.commands.diagnose import Diagnosis, diagnose
from hannes.core.errors import HannesError
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis.before_after import left, simulated
from hannes.identification.gap_change import GapChange, gap_changes


def measured(name: str, seed: int) -> dict[str, Any]:
    """The verdict of a case, and what it does to runs that were not in the campaign."""
    kind = NAMED[name]
    effects = hidden(kind, seed)
    try:
        whole = make(plan(), seed, effects, SPREAD)
    except HannesError as failed:
        return {"not_made": str(failed), "hidden": effects}
    with tempfile.TemporaryDirectory() as folder:
        campaign = _written(whole, Path(folder), kind.stated)
        spent = time.process_time()
        try:
            found = diagnose(campaign, progress=False)
        except HannesError as failed:
            return {"hidden": effects, "verdict": "none", "reason": str(failed)}
    verdict = found.verdict
    return {
        "hidden": effects,
        "verdict": verdict.verdict,
        "named": verdict.effects,
        "reason": verdict.reason,
        "cautions": verdict.cautions,
        "gap": {n: [g[k] for k in ("as_given", "before", "after", "floor")]
                for n, g in verdict.gap.items()},
        "sizes": {n: [p["value"], p["low"], p["high"]] for n, p in verdict.parameters.items()},
        "processor_seconds": time.process_time() - spent,
        **held(found, _fresh(whole, found)),
    }  # fmt: skip


def _written(whole: Made, folder: Path, stated: bool) -> Path:
    """The campaign without the runs that were made again."""
    kept = {n: c for n, c in whole.conditions.items() if not c.startswith(AGAIN)}
    made = replace(whole, conditions=kept, recordings={n: whole.recordings[n] for n in kept})
    if stated:
        made.write(folder)
    else:
        made.write_unstated(folder, SHIPPED)
    return folder / "campaign.toml"


def _fresh(whole: Made, found: Diagnosis) -> list[Segment]:
    """The runs made again, as the diagnosis took those of the campaign."""
    taken = found.details.found.baseline.model.groups if found.details else []
    texts = {each.condition: each.recording.experiment for g in taken for each in g.entries}
    made = []
    for name, condition in whole.conditions.items():
        if condition.startswith(AGAIN):
            recording = replace(
                whole.recordings[name], experiment=texts[condition.removeprefix(AGAIN)]
            )
            made.append(Segment(Entry(name, recording, condition), "", _every(recording)))
    return made


def _every(recording: Recording) -> np.ndarray:
    return np.ones(len(recording), bool)


def held(found: Diagnosis, fresh: Sequence[Segment]) -> dict[str, Any]:
    """Gaps of one fresh run of each condition that refitting or naming raises beyond chance.

    The others say how far runs differ.
    """
    details = found.details
    if details is None:
        return {"worse": [], "changes": []}
    one = {each.entry.condition: each for each in fresh}
    shown = [each for each in fresh if each in one.values()]
    model = details.found.baseline.model
    places = np.array([each.x for each in details.stages.points])
    with model.work.in_any_case():  # also where the diagnosis was ended at its bound
        made = simulated(model, [each.entry for each in shown], places)
    names = list(found.noise_floors)
    raws = [left(shown, [each[k] or {} for each in made], names) for k in range(len(places))]
    worse, rows = [], []
    for what, first in (("refitted or named", 0), ("named", 1)):
        for each in gap_changes(
            model.small, fresh, shown, raws[first], raws[2], found.noise_floors
        ):
            rows.append([what, *_row(each)])
            worse += [f"{what}: {each.text}"] if each.worse else []
    return {"worse": worse, "changes": rows}


def _row(each: GapChange) -> list[Any]:
    times = each.rise / max(each.quantile * each.spread, 1e-30)
    return [each.channel, each.before, each.after, times]
