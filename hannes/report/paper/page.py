"""`hannes reproduce`: the paper's experiments, its figures and tables beside ours, one page."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hannes.core.io.atomic_files import atomic_folder
from hannes.core.version import VERSION
from hannes.report.figure import Drawn
from hannes.report.page import holding, render
from hannes.report.paper import checks, published, tables
from hannes.report.paper.energy import energy_row
from hannes.report.paper.figures import figures
from hannes.report.paper.runs import Runs, measured, run_all
from hannes.report.paper.summary import summary
from hannes.report.schematic import schematic
from hannes.report.verdict_summary import Finding, findings


def reproduce(
    out: str | Path, progress: bool | None = None, *, quick: bool = False
) -> dict[str, Any]:
    """Write the page without any diagnosis to `out`, whole or not at all; see `write_page`."""
    with atomic_folder(out, "reproduce") as folder:
        content = write_page(folder, progress, quick=quick)
    return {**content, "out": str(out)}


def write_page(
    folder: Path,
    progress: bool | None = None,
    *,
    quick: bool = False,
    diagnoses: Mapping[str, Any] | None = None,
    more: Sequence[checks.Row] = (),
) -> dict[str, Any]:
    """Simulate the paper's experiments; write `index.html`, `figures/`, `summary.json`.

    `diagnoses` maps "emps" and "slack" to a Finding, the content of a verdict.json, or the reason
    why there is none; `more` are further rows that must hold. `quick` runs a short sweep. Returns
    `rows` and `must_show`. Raises ComputationFailed where a simulation fails.
    """
    runs = run_all(quick=quick, progress=progress)
    drawings = figures(runs)
    must_show = [*checks.must_show(runs), energy_row(progress), *more]
    page = render("page.html.j2", _content(runs, drawings, must_show, findings(diagnoses)))
    content = summary(runs, must_show)
    (folder / "index.html").write_text(page, encoding="utf-8", newline="\n")
    (folder / "summary.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    (folder / "figures").mkdir()
    for each in drawings.values():
        file = folder / "figures" / f"{each.name}.svg"
        file.write_text(each.svg, encoding="utf-8", newline="\n")
    return {"rows": content["rows"], "must_show": must_show}


def _content(
    runs: Runs, drawings: Mapping[str, Drawn], must_show: list[checks.Row], found: list[Finding]
) -> dict[str, Any]:
    return {
        "version": VERSION,
        "paper_title": published.TITLE,
        "simulations": 5 + len(runs.hands) + len(runs.sweep),
        "must_show": tables.must_show_table(must_show),
        "holding": holding(must_show),
        "figures": drawings,
        "schematic": schematic(runs.hand),
        "findings": found,
        "table1": tables.table_1(runs.hand),
        "table2": tables.table_2(measured(runs.rigid)),
        "void": tables.void_table(runs.hand, runs.unit_hand, runs.unit),
        "definitions": tables.definitions(),
        "parameters": tables.parameters(runs.hand),
    }
