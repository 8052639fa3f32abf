"""Reads the log of an Inspire RH56 hand: trials of one finger, one below the other.

Columns as correlllab/rh56_controller writes them. `Middle_Force_g` and `Middle_Force_N` are the
same raw number, counts, neither grams nor newton.
"""

import csv
import re
from array import array
from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.bounded import lines
from hannes.core.recording.recording import Recording

MOST_TRIALS = 10_000
COLUMNS = {"Trial_Elapsed_s": "time", "Middle_Angle": "angle", "Middle_Force_g": "force"}
UNITS = {"time": "s", "angle": "1", "force": "1"}
_TITLE = re.compile(r"([a-z]+)(\d*)_force(\d+)")  # middlefinger_speed250_force500_20trials_...


def is_log(path: Path) -> bool:
    """Whether a file is such a log: by the columns that no recording of ours has."""
    return ".csv" in path.suffixes and "Trial_Index" in next(lines(path), "")


def load(path: Path) -> dict[str, Recording]:
    """Return the trials in their order, by name; BadInput where a column or a number is missing."""
    rows = csv.DictReader(lines(path))
    wanted, found = ("Trial_Index", *COLUMNS), array("d")
    try:
        if missing := [name for name in wanted if name not in (rows.fieldnames or ())]:
            lacks = ", ".join(missing)
            raise BadInput(f"{path}, line 1: lacks {lacks}: expected a log of a finger")
        for row in rows:
            found.extend([float(row[name]) for name in wanted])
    except (TypeError, ValueError, csv.Error) as error:
        raise BadInput(f"{path}, line {rows.line_num}: no number: {error}") from None
    if not found:
        raise BadInput(f"{path}: a header without rows")
    table = np.frombuffer(found).reshape(-1, len(wanted))
    if not np.isfinite(table).all():
        raise BadInput(f"{path}: a number is not finite")
    if np.unique(table[:, 0]).size > MOST_TRIALS:
        raise BadInput(f"{path}: more than {MOST_TRIALS} trials")
    return {
        f"{_title(path)}, trial {trial:g}": _recording(table[table[:, 0] == trial, 1:], path)
        for trial in np.unique(table[:, 0])
    }


def _recording(rows: np.ndarray, path: Path) -> Recording:
    try:
        return Recording(dict(zip(COLUMNS.values(), rows.T, strict=True)), UNITS, plant="finger")
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _title(path: Path) -> str:
    """`speed 250, limit 500` from the name of the file, or the name."""
    found = _TITLE.search(path.name)
    return f"{found[1]} {found[2]}, limit {found[3]}".replace(" ,", ",") if found else path.name
