"""Reads the log of an Inspire RH56 hand: trials of one finger, one below the other.

Columns as correlllab/rh56_controller writes them. `Middle_Force_g` and `Middle_Force_N` are the
same raw number, counts, neither grams nor newton.
"""

import csv
import io
import re
from pathlib import Path

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.recording.csv import read_bytes
from hannes.core.recording.recording import Recording

COLUMNS = {"Trial_Elapsed_s": "time", "Middle_Angle": "angle", "Middle_Force_g": "force"}
UNITS = {"time": "s", "angle": "1", "force": "1"}
_TITLE = re.compile(r"([a-z]+)(\d*)_force(\d+)")  # middlefinger_speed250_force500_20trials_...


def is_log(path: Path) -> bool:
    """Whether a file is such a log: by the columns that no recording of ours has."""
    if ".csv" not in path.suffixes:
        return False
    return b"Trial_Index" in read_bytes(path).partition(b"\n")[0]


def load(path: Path) -> dict[str, Recording]:
    """Return the trials in their order, by name; BadInput where a column or a number is missing."""
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: no UTF-8 text: {error.reason} at byte {error.start}") from None
    rows = csv.DictReader(io.StringIO(text, newline=""))
    wanted = ("Trial_Index", *COLUMNS)
    try:
        if missing := [name for name in wanted if name not in (rows.fieldnames or ())]:
            lacks = ", ".join(missing)
            raise BadInput(f"{path}, line 1: lacks {lacks}: expected a log of a finger")
        table = np.array([[float(row[name]) for name in wanted] for row in rows])
    except (TypeError, ValueError, csv.Error) as error:
        raise BadInput(f"{path}, line {rows.line_num}: no number: {error}") from None
    if not table.size:
        raise BadInput(f"{path}: a header without rows")
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
