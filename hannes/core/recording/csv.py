"""Recordings as CSV: a header of `name_unit` columns, then numbers only.

numpy parses the whole file at once. Only if that fails are the lines checked one by one, to name
the faulty one.
"""

import csv
import gzip
import re
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput
from hannes.core.io.inputs import is_file, note

FloatArray = NDArray[np.float64]

LARGEST = 512 * 2**20  # bytes of text; an hour at 1 kHz with 8 channels has some 300 MB

_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*", re.ASCII)
_NOT_FINITE = re.compile(r"\s*[+-]?(?:nan|inf|infinity)\s*", re.ASCII | re.IGNORECASE)


def load(path: Path) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Return (channels, units) in column order; BadInput with file and line otherwise."""
    lines = _lines(path, read_bytes(path))
    columns = _header(path, lines[0])
    names = [name for name, _ in columns]
    table = _table(path, lines[1:], names)
    _require_increasing(path, table, names)
    return {name: table[:, i] for i, name in enumerate(names)}, dict(columns)


def dump(channels: Mapping[str, FloatArray], units: Mapping[str, str], packed: bool) -> bytes:
    """Return the file's bytes, gzipped without a time stamp if `packed`."""
    rows = zip(*(each.tolist() for each in channels.values()), strict=True)
    lines = [",".join(f"{name}_{units[name]}" for name in channels)]
    lines += [",".join(map(repr, row)) for row in rows]
    data = ("\n".join(lines) + "\n").encode()
    return gzip.compress(data, mtime=0) if packed else data


def read_bytes(path: Path) -> bytes:
    """Return a file's bytes, unpacked where its name ends in .gz; BadInput if that fails."""
    note(path)
    if not is_file(path):
        raise BadInput(f"{path}: expected a CSV file, there is no such file")
    try:
        with gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(f"{path}: cannot be read: {reason}") from None
    if len(data) > LARGEST:
        raise BadInput(f"{path}: longer than {LARGEST >> 20} MB; cut it into shorter recordings")
    return data


def _lines(path: Path, data: bytes) -> list[str]:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise BadInput(f"{path}, line {line}: not UTF-8 text; save the file as UTF-8") from None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    if lines == [""]:
        raise BadInput(f"{path}, line 1: the file is empty, expected a header such as time_s,...")
    return lines


def _header(path: Path, line: str) -> list[tuple[str, str]]:
    """Return (name, unit) of each column."""
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


def _table(path: Path, lines: list[str], names: list[str]) -> FloatArray:
    """Return the numbers, rows x columns."""
    if len(lines) < 2:
        raise BadInput(
            f"{path}, line {len(lines) + 1}: the file ends here, expected two or more rows"
        )
    try:
        table = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        table = np.empty((0, 0))
    if table.shape != (len(lines), len(names)) or not np.isfinite(table).all():
        for number, line in enumerate(lines, start=2):
            _check_row(f"{path}, line {number}", line.split(","), names)
        raise BadInput(f"{path}: expected rows of {len(names)} numbers separated by commas")
    return table


def _check_row(place: str, cells: list[str], names: list[str]) -> None:
    if cells == [""]:
        raise BadInput(f"{place}: the line is empty; leave out rows without data")
    if len(cells) != len(names):
        raise BadInput(f"{place}: expected {len(names)} columns as in the header, got {len(cells)}")
    for name, cell in zip(names, cells, strict=True):
        if _NOT_FINITE.fullmatch(cell) or (_NUMBER.fullmatch(cell) and np.isinf(float(cell))):
            raise BadInput(f"{place}: {name} is not finite; leave out rows without data")
        if not _NUMBER.fullmatch(cell):
            raise BadInput(f"{place}: {name} = {cell!r:.60} is not a number")


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
