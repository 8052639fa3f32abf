"""`hannes reproduce`: the paper's experiments and a first diagnosis, on one page."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaign import read_campaign
from hannes.diagnose import Diagnosis, Traces, diagnose
from hannes.errors import BadInput, HannesError, MissingRecording
from hannes.report.checks import Row, row
from hannes.report.findings import Finding, finding
from hannes.report.reproduce import reproduce as paper_page
from hannes.report.tables import Table

# Relative force errors of the closed-loop simulation [%], identification and pulses file.
PUBLISHED = (5.848, 8.94)  # Janot, Gautier & Brunot (2019), Coulomb + viscous + offset
BOUNDS = (4.6, 5.6)  # what an independent simulation with the published parameters reached
GAIN = 0.5  # points that the missing effect is worth at least on the file not fitted


def reproduce(
    out: str | Path, *, slack: str | Path | None = None, progress: bool | None = None
) -> dict[str, Any]:
    """Write the page to `out` and the diagnosis of the real axis beside it, to `out`/../emps.

    `slack` is the results folder of a diagnosis of closures with hidden slack. Returns `rows`,
    `must_show` and `out`. Raises BadInput where a folder cannot be used, ComputationFailed where
    a simulation fails; a recording that is missing is named on the page instead.
    """
    emps, rows = _emps(Path(out).parent / "emps", progress)
    found = {"emps": emps, "slack": _given(slack, Path(out))}
    return paper_page(out, progress, diagnoses=found, more=rows)


def _emps(folder: Path, progress: bool | None) -> tuple[Finding | HannesError, list[Row]]:
    try:
        campaign = read_campaign("emps")
    except MissingRecording as missing:
        return missing, []
    result = diagnose(campaign, out=folder, progress=progress)
    errors = [force_errors(each) for each in result.traces]
    made = finding(
        "emps",
        json.loads(result.verdict.json()),
        link=f"../{folder.name}/report.html",
        tables=(_table(result, errors),),
    )
    return made, _rows(result, errors)


def force_errors(traces: Traces) -> tuple[float, float, float]:
    """Relative error of the drive as given, refitted, with the effect [%].

    100 |measured - simulated| / |measured| from 0.1 s to 0.05 s before the end.
    """
    measured = traces.measured["drive"][traces.mask]
    size = np.linalg.norm(measured)
    stages = (traces.as_given, traces.before, traces.after)
    off = [np.linalg.norm(measured - stage["drive"][traces.mask]) for stage in stages]
    return tuple(100.0 * float(each / size) for each in off)  # type: ignore[return-value]


def _table(result: Diagnosis, errors: list[tuple[float, float, float]]) -> Table:
    names = [each.entry.name for each in result.traces]
    rows = tuple(
        (f"{name} ({each.entry.role})", f"{published:.2f}", *(f"{e:.2f}" for e in error))
        for name, published, error, each in zip(
            names, PUBLISHED, errors, result.traces, strict=True
        )
    )
    return Table(
        "emps-errors",
        "Relative force error [%]",
        ("File", "Published simulation", "Published parameters, here", "Refitted", "With effect"),
        rows,
        "100 |measured - simulated| / |measured| of the drive, closed loop from the recorded "
        "reference, start position and speed from the record, 0.1 s to 0.05 s before the end.",
    )


def _rows(result: Diagnosis, errors: list[tuple[float, float, float]]) -> list[Row]:
    named = result.verdict.effects == ["direction_friction"]
    gain = errors[1][1] - errors[1][2]
    return [
        row("EMPS, published parameters, fitted file", errors[0][0], BOUNDS[0], "%"),
        row("EMPS, published parameters, other file", errors[1][0], BOUNDS[1], "%"),
        row("EMPS, effects named that are not direction_friction", float(not named), 0.0),
        row(
            "EMPS, other file with the effect, below the refitted base by at least 0.5 points",
            -gain,
            -GAIN,
            "points",
        ),
    ]


def _given(folder: str | Path | None, out: Path) -> Finding | str:
    if folder is None:
        return "not diagnosed in this run; `make run` makes the closures and diagnoses them"
    file = Path(folder) / "verdict.json"
    try:
        verdict = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{file} is no verdict of a diagnosis: {error}") from None
    link = Path(folder).resolve() / "report.html"
    try:
        shown = link.relative_to(out.resolve().parent)
        return finding("slack", verdict, link=f"../{shown.as_posix()}")
    except ValueError:
        return finding("slack", verdict, link=link.as_uri())
