"""Columns of spreadsheets (.xlsx): sheets that have numbers below a row of names.

A row of units may stand between names and numbers.
"""

import math
import zipfile
from array import array
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays, require_file
from hannes.campaigns.foreign.nested import as_float
from hannes.campaigns.foreign.spelled_units import are_units
from hannes.core.errors import BadInput
from hannes.core.io.limits import COLUMNS, MIB, SHEET_BYTES, table_fits
from hannes.core.io.optional import library

MOST_ROWS = 1_048_576  # that a sheet can have
FEWEST = 2  # rows of numbers below the names


def open_sheet(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read a workbook; columns by name, or `sheet/name` where several sheets have numbers."""
    require_file(path)
    openpyxl = library("openpyxl", "formats")
    try:
        decoded = _unpacked(path)
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = {sheet.title: _columns(sheet, decoded) for sheet in book.worksheets}
        book.close()
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as a workbook ({reason})") from None
    full = {title: sheet for title, sheet in sheets.items() if sheet.columns}
    if not full:
        raise BadInput(f"{path}: no sheet has numbers below a row of names")
    found: dict[str, np.ndarray] = {}
    captions: dict[str, str] = {}
    for title, sheet in full.items():
        start = f"{title}/" if len(full) > 1 else ""
        found |= {start + name: x for name, x in sheet.columns.items()}
        captions |= {start + name: caption for name, caption in sheet.captions.items()}
    return Arrays(path, found, found.__getitem__, missing, captions)


def _unpacked(path: Path) -> int:
    """Bytes to which a workbook unpacks: its reader takes no more than each part states."""
    with zipfile.ZipFile(path) as archive:
        size = sum(each.file_size for each in archive.infolist())
    if size > SHEET_BYTES:
        raise BadInput(
            f"unpacks to {size // MIB} MiB, more than {SHEET_BYTES // MIB}; save as .csv"
        )
    return size


@dataclass(frozen=True)
class _Sheet:
    """Columns (n,) of a sheet by name, and names with their units."""

    columns: dict[str, np.ndarray]
    captions: dict[str, str]


def _columns(sheet: Any, decoded: int) -> _Sheet:
    """Columns below the first row of texts that rows of numbers follow."""
    names: list[str] = []
    units: list[str] = []
    rows = array("d")
    sheet.reset_dimensions()  # stated by the file
    for cells in sheet.iter_rows(values_only=True, max_row=MOST_ROWS):
        if len(cells) > COLUMNS:
            raise BadInput(f"has more than {COLUMNS} columns")
        texts = [str(cell).strip() if isinstance(cell, str) else "" for cell in cells]
        numbers = [_number(cell) for cell in cells]
        if sum(map(bool, texts)) > sum(map(math.isfinite, numbers)):
            if names and not rows and are_units(texts):
                units = texts
            elif len(rows) < FEWEST * len(names) or not names:
                names = [str(cell).strip() if cell is not None else "" for cell in cells]
                units, rows = [], array("d")
        elif names and any(map(math.isfinite, numbers)):
            rows.extend(numbers[: len(names)] + [math.nan] * (len(names) - len(numbers)))
            if not table_fits(len(rows), 1, decoded):
                raise BadInput(f"{len(names)} columns, most of them empty, are too large")
    return _sheet(names, units, rows)


def _sheet(names: list[str], units: list[str], rows: "array[float]") -> _Sheet:
    if not names or len(rows) < FEWEST * len(names):
        return _Sheet({}, {})
    table = np.frombuffer(rows).reshape(-1, len(names))
    columns = {
        name: table[:, k] for k, name in enumerate(names) if name and np.isfinite(table[:, k]).any()
    }
    units += [""] * len(names)
    captions = {
        name: f"{name} [{unit.strip('[]() ')}]"
        for name, unit in zip(names, units, strict=False)
        if unit and name in columns
    }
    return _Sheet(columns, captions)


def _number(cell: Any) -> float:
    """Value of a cell; of a date or time its seconds since 1970."""
    import datetime

    if isinstance(cell, bool | int | float):
        return as_float(cell)
    if isinstance(cell, datetime.datetime):
        return cell.replace(tzinfo=cell.tzinfo or datetime.UTC).timestamp()
    if isinstance(cell, datetime.time):
        return 3600.0 * cell.hour + 60.0 * cell.minute + cell.second + 1e-6 * cell.microsecond
    return float("nan")
