"""Columns of spreadsheets (.xlsx): the first sheet that has numbers below a row of names."""

from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.core.errors import BadInput
from hannes.core.io.optional import library

MOST_ROWS = 1_048_576  # that a sheet can have
FEWEST = 2  # rows of numbers below the names


def open_sheet(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read a workbook; columns by name, or `sheet/name` where several sheets have numbers."""
    if not path.is_file():
        raise BadInput(f"{path}: there is no such file")
    openpyxl = library("openpyxl", "formats")
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = {sheet.title: _columns(sheet) for sheet in book.worksheets}
        book.close()
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as a workbook ({reason})") from None
    full = {title: columns for title, columns in sheets.items() if columns}
    if not full:
        raise BadInput(f"{path}: no sheet has numbers below a row of names")
    if len(full) == 1:
        (found,) = full.values()
    else:
        found = {f"{title}/{name}": x for title, each in full.items() for name, x in each.items()}
    return Arrays(path, found, found.__getitem__, missing)


def _columns(sheet: Any) -> dict[str, np.ndarray]:
    """Columns below the first row of texts that rows of numbers follow."""
    names: list[str] = []
    rows: list[list[float]] = []
    for cells in sheet.iter_rows(values_only=True, max_row=MOST_ROWS):
        texts = [isinstance(cell, str) and bool(cell.strip()) for cell in cells]
        numbers = [_number(cell) for cell in cells]
        if sum(texts) > sum(np.isfinite(numbers)):
            if len(rows) < FEWEST:
                names = [str(cell).strip() if cell is not None else "" for cell in cells]
                rows = []
        elif names and np.isfinite(numbers).any():
            rows.append(numbers[: len(names)] + [np.nan] * (len(names) - len(numbers)))
    if len(rows) < FEWEST:
        return {}
    table = np.array(rows)
    return {name: table[:, k] for k, name in enumerate(names) if name}


def _number(cell: Any) -> float:
    """Value of a cell; of a date or time its seconds since 1970."""
    import datetime

    if isinstance(cell, bool | int | float):
        return float(cell)
    if isinstance(cell, datetime.datetime):
        return cell.replace(tzinfo=cell.tzinfo or datetime.UTC).timestamp()
    if isinstance(cell, datetime.time):
        return 3600.0 * cell.hour + 60.0 * cell.minute + cell.second + 1e-6 * cell.microsecond
    return float("nan")
