"""Recordings as CSV: a header of `name_unit` columns, then numbers only.

numpy parses the lines as they are read and unpacked. Only if that fails are they checked one by
one, to name the faulty one.
"""

import csv
import gzip
import itertools
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput
from hannes.core.io.bounded import lines
from hannes.core.io.limits import CHANNELS, MAGNITUDE, VALUES

FloatArray = NDArray[np.float64]

WHAT = "a CSV file"

_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*", re.ASCII)
_NOT_FINITE = re.compile(r"\s*[+-]?(?:nan|inf|infinity)\s*", re.ASCII | re.IGNORECASE)


def load(path: Path) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Return (channels, units) in column order; BadInput with file and line otherwise."""
    columns = _header(path, next(_lines(path), ""))
    names = [name for name, _ in columns]
    table = _table(path, names)
    _require_possible(path, table, names)
    _require_increasing(path, table, names)
    return {name: table[:, i] for i, name in enumerate(names)}, dict(columns)


def dump(channels: Mapping[str, FloatArray], units: Mapping[str, str], packed: bool) -> bytes:
    """Return the file's bytes, gzipped without a time stamp if `packed`."""
    rows = zip(*(each.tolist() for each in channels.values()), strict=True)
    text = [",".join(f"{name}_{units[name]}" for name in channels)]
    text += [",".join(map(repr, row)) for row in rows]
    data = ("\n".join(text) + "\n").encode()
    return gzip.compress(data, mtime=0) if packed else data


def _lines(path: Path) -> Iterator[str]:
    return lines(path, what=WHAT, advice="; save the file as UTF-8")


def _header(path: Path, line: str) -> list[tuple[str, str]]:
    """Return (name, unit) of each column."""
    if not line:
        raise BadInput(f"{path}, line 1: the file is empty, expected a header such as time_s,...")
    if line.count(",") >= CHANNELS:
        raise BadInput(f"{path}, line 1: has more than {CHANNELS} columns")
    try:
        cells = [cell.strip() for cell in next(csv.reader([line], strict=True), [])]
    except csv.Error as error:
        raise BadInput(f"{path}, line 1: unreadable header: {error}") from None
    if all(_NUMBER.fullmatch(cell) for cell in cells):
        raise BadInput(f"{path}, line 1: expected a header such as time_s,current_A, got numbers")
    columns = [_column(path, cell) for cell in cells]
    names = [name for name, _ in columns]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(f'{path}, line 1: channel "{name}" has more than one column')
    return columns


def _column(path: Path, cell: str) -> tuple[str, str]:
    name, _, unit = cell.rpartition("_")
    foreign = ";" in cell or "\t" in cell
    if name and unit and not foreign:
        return name, unit
    advice = "separate columns by commas" if foreign else "such as current_A"
    raise BadInput(
        f"{path}, line 1: column {cell!r:.60} is not of the form name_unit "
        f"(unit 1 for none): {advice}"
    )


def _table(path: Path, names: list[str]) -> FloatArray:
    """Return the numbers, rows x columns."""
    rows = _Rows(path, len(names))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # no rows: said below
            table = np.loadtxt(iter(rows), delimiter=",", comments=None, ndmin=2)
    except ValueError:
        table = np.empty((0, 0))
    if table.shape != (rows.count, len(names)) or not np.isfinite(table).all():
        for number, line in enumerate(_Rows(path, len(names)), start=2):
            _check_row(f"{path}, line {number}", line.split(","), names)
    if rows.count < 2:
        number = rows.count + 1
        raise BadInput(f"{path}, line {number}: the file ends here, expected two or more rows")
    if table.shape != (rows.count, len(names)):
        raise BadInput(f"{path}: expected rows of {len(names)} numbers separated by commas")
    return table


class _Rows:
    """Lines below the header, counted; empty ones at the end are passed over."""

    def __init__(self, path: Path, width: int) -> None:
        self.path, self.most, self.count = path, VALUES // width, 0

    def __iter__(self) -> Iterator[str]:
        empty = 0
        for line in itertools.islice(_lines(self.path), 1, None):
            if not line:
                empty += 1
                continue
            if empty:
                raise BadInput(
                    f"{self.path}, line {self.count + 2}: the line is empty; leave out rows "
                    "without data"
                )
            self.count += 1
            if self.count > self.most:
                raise BadInput(f"{self.path}: holds more than {VALUES} numbers; cut it into parts")
            yield line


def _check_row(place: str, cells: list[str], names: list[str]) -> None:
    if len(cells) != len(names):
        raise BadInput(f"{place}: expected {len(names)} columns as in the header, got {len(cells)}")
    for name, cell in zip(names, cells, strict=True):
        if _NOT_FINITE.fullmatch(cell) or (_NUMBER.fullmatch(cell) and np.isinf(float(cell))):
            raise BadInput(f"{place}: {name} is not finite; leave out rows without data")
        if not _NUMBER.fullmatch(cell):
            raise BadInput(f"{place}: {name} = {cell!r:.60} is not a number")


def _require_possible(path: Path, table: FloatArray, names: list[str]) -> None:
    beyond = np.argwhere(np.abs(table) > MAGNITUDE)
    if beyond.size:
        row, column = beyond[0]
        raise BadInput(
            f"{path}, line {row + 2}: {names[column]} is {table[row, column]:.6g}, beyond "
            f"{MAGNITUDE:g}: no sensor reads that; is the file damaged, or the value a mark for "
            "none?"
        )


def _require_increasing(path: Path, table: FloatArray, names: list[str]) -> None:
    if "time" not in names:
        raise BadInput(f"{path}, line 1: expected a column time_s, got {', '.join(names):.200}")
    time = table[:, names.index("time")]
    stalled = np.flatnonzero(time[1:] <= time[:-1])
    if stalled.size:
        first = int(stalled[0])
        raise BadInput(
            f"{path}, line {first + 3}: time does not increase, "
            f"{time[first]:.15g} s is followed by {time[first + 1]:.15g} s"
        )
