"""Long text files of numbers alone: all columns are parsed at once, without a line in Python.

Whatever is not just numbers between one delimiter is left to `text_columns`, which names the line.
"""

import warnings
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import Column, TextRule
from hannes.campaigns.foreign.text_columns import GUESSES, Delimited, absent
from hannes.core.errors import BadInput
from hannes.core.io.bounded import blocks
from hannes.core.io.limits import COLUMNS, VALUES
from hannes.core.io.optional import library

FloatArray = NDArray[np.float64]

SHORT = 1 << 20  # bytes, below which a file is read line by line
PART = 1 << 22  # bytes parsed at once
NUMBERS = b"0123456789+-.eE \r\n"


class PlainTable:
    """A source of columns, as `Delimited` is; what needs its text is asked of that."""

    def __init__(
        self, path: Path, rule: TextRule, missing: tuple[str, ...], names: list[str],
        table: FloatArray,
    ) -> None:  # fmt: skip
        self.path, self.rule, self.missing, self.names = path, rule, missing, names
        self._table = table

    @cached_property
    def _lines(self) -> Delimited:
        return Delimited(self.path, self.rule, self.missing)

    def __len__(self) -> int:
        return len(self._table)

    def numbers(self, column: Column) -> FloatArray:
        """Values of a column, shape (n,)."""
        if column.index:
            return self._lines.numbers(column)
        if isinstance(column.name, int):
            place = column.name - 1
            if not place < self._table.shape[1]:
                raise BadInput(f"{self.path}: has {self._table.shape[1]} columns, none with "
                               f"number {column.name}")  # fmt: skip
        elif self.names.count(column.name) == 1:
            place = self.names.index(column.name)
        else:
            count = self.names.count(column.name)
            raise BadInput(f"{self.path}: {absent(self.names, column.name, count)}")
        values = self._table[:, place].copy()
        for text in self.missing:
            try:
                values[values == float(text)] = np.nan
            except ValueError:
                continue
        return values

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Seconds since the first stamp of a column of dates and times, shape (n,)."""
        return self._lines.stamps(column, pattern)

    def labels(self, column: Column) -> FloatArray:
        """A number for each distinct text of a column, shape (n,)."""
        return self._lines.labels(column)

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """Rows before which a blank line or a repeated header stands."""
        return self._lines.breaks(kind)

    def place(self, row: int) -> str:
        """File and line of a row, as messages show them."""
        return f"{self.path}, line {self.rule.first + row}"


def plain_table(path: Path, rule: TextRule, missing: tuple[str, ...]) -> PlainTable | None:
    """Read a long file of numbers at once; None where it is short, or holds anything else."""
    if rule.decimal != "." or rule.skip or rule.ragged or rule.encoding != "utf-8":
        return None
    if path.stat().st_size < SHORT:
        return None
    data = b"".join(blocks(path, "a log of samples"))
    if b"\r" in data:  # quicker than to look for both
        data = data.replace(b"\r\n", b"\n")
    start = 0
    heads = []
    for _ in range(rule.first - 1):
        end = data.find(b"\n", start)
        if end < 0:
            return None
        heads.append(data[start:end])
        start = end + 1
    head = _text(heads[rule.header - 1]) if rule.header else ""
    first = _text(data[start : data.find(b"\n", start)])
    if head is None or first is None:
        return None
    delimiter = rule.delimiter or next((each for each in GUESSES if each in (head or first)), " ")
    table = None if delimiter == " " else _parsed(data, start, delimiter.encode(), first)
    if table is None:
        return None
    head = head.strip(" ").removeprefix(rule.comment)
    names = [cell.strip() for cell in head.split(delimiter)] if head else []
    if '"' in head or (names and len(names) != table.shape[1]):
        return None
    return PlainTable(path, rule, missing, names, table)


def _text(line: bytes) -> str | None:
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError:
        return None


def _parsed(data: bytes, start: int, mark: bytes, first: str) -> FloatArray | None:
    """All numbers from a place on, rows x columns; None where they are not that."""
    width = first.count(mark.decode()) + 1
    if width > COLUMNS or data.count(b"\n", start) * width > VALUES:
        return None
    if find_spec("pyarrow") is None:
        return _by_numpy(data, start, mark, width)
    return _by_arrow(data, start, mark.decode(), width)


def _by_arrow(data: bytes, start: int, mark: str, width: int) -> FloatArray | None:
    """By Arrow's reader, where that is installed: four times as fast."""
    arrow, csv = library("pyarrow", "formats"), library("pyarrow.csv", "formats")
    names = [str(k) for k in range(width)]
    try:
        table = csv.read_csv(
            arrow.py_buffer(data).slice(start),
            csv.ReadOptions(column_names=names, use_threads=False),
            csv.ParseOptions(delimiter=mark, quote_char=False, ignore_empty_lines=False),
            csv.ConvertOptions(column_types=dict.fromkeys(names, "float64"), null_values=[]),
        )
    except arrow.ArrowInvalid:
        return None
    columns = np.empty((width, table.num_rows))
    for k, each in enumerate(table.columns):
        columns[k] = each.to_numpy()
    return columns.T if table.num_rows > 1 and np.isfinite(columns).all() else None


def _by_numpy(data: bytes, start: int, mark: bytes, width: int) -> FloatArray | None:
    """Part by part, after a look at every byte and at the width of every line."""
    parts = []
    while start < len(data):
        stop = data.rfind(b"\n", start, start + PART) + 1 or len(data)
        part = data[start:stop]
        if part.translate(None, NUMBERS + mark):
            return None  # texts, codes, comments, quotes
        part = part.rstrip(b"\n")
        marks = np.frombuffer(part, np.uint8)
        at = np.concatenate((np.flatnonzero(marks == ord(b"\n")), [marks.size]))
        counts = np.diff(np.searchsorted(np.flatnonzero(marks == ord(mark)), at), prepend=0)
        found = _numbers(part.replace(b"\n", b","), mark)
        if (counts != width - 1).any() or found is None or found.size != at.size * width:
            return None
        parts.append(found.reshape(at.size, width))
        start = stop
    table = np.concatenate(parts) if parts else np.empty((0, width))
    return table if len(table) > 1 else None


def _numbers(part: bytes, mark: bytes) -> FloatArray | None:
    """Numbers divided by commas; None where a cell is empty or no number."""
    text = part if mark == b"," else part.replace(mark, b",")
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            found = np.fromstring(text, sep=",")
        except (DeprecationWarning, ValueError):
            return None
    return found if np.isfinite(found).all() else None
