"""The real axis EMPS: base refitted on one file by its recorded reference, judged on the other."""

import sys

from benchmarks.harness import Row, must_show
from hannes.commands.calibrate import calibrate
from hannes.core.errors import MissingRecording

FITTED, OTHER = 4.5, 5.4  # % of the recorded drive


def figures() -> tuple[list[Row], list[Row]]:
    """Gap in percent of the drive as given and refitted; nothing where there are no recordings."""
    try:
        found = calibrate("emps", progress=False)
    except MissingRecording as missing:
        print(f"EMPS left out: {missing}", file=sys.stderr)
        return [], []
    rows, bounds = [], []
    for file, gap, bound in (("fitted", found.fitted_gap, FITTED), ("other", found.gap, OTHER)):
        share = {
            key: 100.0 * gap["drive"][key] / gap["drive"]["recorded"]
            for key in ("as_given", "after")
        }
        rows.append({"study": "EMPS", "file": file, **share})
        name = f"EMPS, {file} file: force gap of the refitted base [%]"
        bounds.append(must_show(name, share["after"], bound, share["after"] <= bound))
    return rows, bounds
