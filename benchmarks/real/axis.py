"""EMPS: direction-dependent friction is named, and what it is worth on the file not fitted."""

from collections.abc import Sequence

import numpy as np

from benchmarks.harness import Row, must_show
from benchmarks.real import blocks
from hannes.commands.diagnose import Diagnosis
from hannes.commands.reproduce import force_errors
from hannes.identification.residuals import Traces

EFFECT = "direction_friction"  # the published answer
MOST = 4.75  # % of the recorded drive, with the effect
LEAST_GAIN = 0.6  # points below the refitted base


def figures(found: Diagnosis) -> tuple[list[Row], list[Row]]:
    """Force errors of both files, and what must be shown of the one not fitted."""
    rows = [_errors(each) for each in found.traces]
    (shown,) = [each for each in found.traces if each.entry.role == "show"]
    sums = _sums(shown, found.campaign.plant.block)
    error = blocks.row("EMPS, other file: force error with the effect [%]", sums, _after)
    gain = blocks.row("EMPS, other file: below the refitted base [points]", sums, _gain)
    named = found.verdict.effects == [EFFECT]
    remainder = found.verdict.verdict == "named_with_remainder"
    return rows, [
        must_show("EMPS: named as direction_friction, alone", float(named), 1.0, named),
        {**must_show("", error["value"], MOST, error["value"] <= MOST), **error},
        {**must_show("", gain["value"], LEAST_GAIN, gain["value"] >= LEAST_GAIN), **gain},
        must_show("EMPS: the remainder is reported", float(remainder), 1.0, remainder),
    ]


def _errors(traces: Traces) -> Row:
    stages = ("as given", "base refitted", "with the effect")
    errors = dict(zip(stages, force_errors(traces), strict=True))
    return {"machine": f"EMPS, {traces.entry.role} [%]", **errors}


def _sums(traces: Traces, block: float) -> np.ndarray:
    """Squares of what is left before, after, and of the drive, of every block."""
    drive = traces.measured["drive"]
    arrays = [traces.before["drive"] - drive, traces.after["drive"] - drive, drive]
    numbers = (traces.time / block).astype(int)[traces.mask]
    counted = [each[traces.mask] for each in arrays]
    return blocks.squares([[each[numbers == k] for each in counted] for k in np.unique(numbers)])


def _after(sums: Sequence[float]) -> float:
    return 100.0 * float(np.sqrt(sums[1] / sums[2]))


def _gain(sums: Sequence[float]) -> float:
    return 100.0 * float(np.sqrt(sums[0] / sums[2])) - _after(sums)
