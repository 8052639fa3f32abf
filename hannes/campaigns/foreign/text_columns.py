"""Columns of a text file: any delimiter, decimal comma, comments, lines above the numbers.

numpy parses a column at once. Only where that fails are its cells read one by one, to accept
missing values and to name the faulty line.
"""

import csv
import re
from array import array
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import Column, TextRule
from hannes.campaigns.foreign.serial_lines import STAMP, SerialForm, serial_form
from hannes.campaigns.foreign.skip_pattern import leaves_out, skipper
from hannes.campaigns.foreign.text_codes import TextCodes, Texts
from hannes.campaigns.foreign.text_lines import Lines
from hannes.core.errors import BadInput, nearest
from hannes.core.io.bounded import lines
from hannes.core.io.limits import COLUMNS

FloatArray = NDArray[np.float64]

FIRST = np.zeros(1, np.intp)
GUESSES = ("\t", ";", ",")  # else any white space


class Delimited:
    """A text file divided into lines; NaN stands for a missing value."""

    def __init__(self, path: Path, rule: TextRule, missing: tuple[str, ...]) -> None:
        self.path, self.rule, self.missing = path, rule, {"", *missing}
        self._skip = skipper(rule.skip)
        self._breaks = {"blank": array("q"), "header": array("q")}
        self.numbers_of_lines, self.rows = array("q"), Lines()
        self._form = self._serial_form()
        head = self._read()
        self.delimiter = rule.delimiter or self._guessed(head or self.rows[0])
        self.names = [cell.strip() for cell in self._cells(head)] if head else []
        if rule.stamped and self.names:
            self.names[0] = STAMP
        self._check_widths(len(self.names) or len(self._cells(self.rows[0])))

    def _read(self) -> str:
        """Keep the lines of numbers, note blank ones and repeated headers; return the header."""
        head, number, ends = self._form.head if self.rule.pairs and self._form else "", 0, 0
        for number, line in self._plain_lines():
            ends = number if line else ends
            if number == self.rule.header:
                head = line
            if number >= self.rule.first:
                self._keep(number, line, head)
        if number < self.rule.header:
            raise BadInput(f"{self.path}: has {number} lines, none with number {self.rule.header}")
        if not ends:
            raise BadInput(f"{self.path}, line 1: the file is empty")
        if len(self.rows) < 2:
            raise BadInput(
                f"{self.path}, line {ends}: the file ends here; expected two or more lines of "
                f"numbers from line {self.rule.first} on"
            )
        mark = self.rule.comment
        return head.strip(" ").removeprefix(mark) if mark else head

    def _serial_form(self) -> SerialForm | None:
        rule = self.rule
        if not rule.stamped and not rule.pairs:
            return None
        lines = _lines(self.path, rule.encoding)
        return serial_form(lines, rule.delimiter, rule.stamped, rule.pairs)

    def _plain_lines(self) -> Iterator[tuple[int, str]]:
        """Lines by number; of a serial monitor's as cells, those that are no samples left out."""
        form, numbered = self._form, enumerate(_lines(self.path, self.rule.encoding), start=1)
        if form is None:
            yield from numbered
            return
        for number, line in numbered:
            rest = form.rest(line)
            left = number != self.rule.header and rest.strip() and self._skipped(rest)
            plain = None if left else form.plain(line) if rest.strip() else ""
            if plain is not None:
                yield number, plain

    def _is_head(self, line: str, head: str) -> bool:
        """Whether a line is the header again, at another time of a serial monitor."""
        mark = self.rule.delimiter
        return self.rule.stamped and line.partition(mark)[2] == head.partition(mark)[2]

    def _keep(self, number: int, line: str, head: str) -> None:
        if self._skipped(line):
            if not line.strip():
                self._breaks["blank"].append(len(self.rows))
        elif self.rule.header and (line == head or self._is_head(line, head)):
            self._breaks["header"].append(len(self.rows))
        else:
            self.numbers_of_lines.append(number)
            self.rows.append(line)

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """Rows before which a blank line or a repeated header stands, as `kind` says."""
        if kind not in self._breaks:
            raise BadInput(f'{self.path}: split_at = "{kind}" is not of text')
        found = np.unique(np.array(self._breaks[kind], np.intp))
        return found[(found > 0) & (found < len(self.rows))]

    def labels(self, column: Column) -> FloatArray:
        """A number for each distinct text of a column, shape (n,); an empty cell goes on."""
        numbers: dict[str, float] = {}
        found, last = array("d"), ""
        for cell in self._column_cells(self._index(column)):
            last = cell or last
            found.append(numbers.setdefault(last, float(len(numbers))))
        return np.array(found)

    def texts(self, column: Column) -> Texts:
        """A column of names; BadInput where it has too many different ones."""
        codes = TextCodes()
        for cell in self._column_cells(self._index(column)):
            codes.extend([cell or None], FIRST)
        if (found := codes.texts) is None:
            raise BadInput(f'{self.path}: "{column.name}" has no names, or too many')
        return found

    def __len__(self) -> int:
        return len(self.rows)

    def place(self, row: int) -> str:
        """File and line of a row, as messages show them."""
        return f"{self.path}, line {self.numbers_of_lines[row]}"

    def numbers(self, column: Column) -> FloatArray:
        """Values of a column, shape (n,); BadInput with the line where one is no number."""
        index = self._index(column)
        if column.index:
            return self._of_lists(index, column.index)
        if self.rule.ragged:
            return self._of_cells(index)
        try:
            values = np.loadtxt(
                iter(self._dotted),
                delimiter=None if self.delimiter == " " else self.delimiter,
                comments=None,
                usecols=index,
                quotechar='"',
                ndmin=1,
            )
        except ValueError:
            values = self._of_cells(index)
        for text in self.missing:
            values[values == _as_number(text)] = np.nan
        if np.isinf(values).any():
            row = int(np.isinf(values).argmax())
            raise BadInput(f"{self.place(row)}: the value is not finite; list it under missing")
        return values

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Seconds since the first stamp, shape (n,), of a column of dates and times.

        They are ISO 8601, or as `pattern` of strptime says.
        """
        cells = self._column_cells(self._index(column))
        found = [self._stamp(row, cell, pattern) for row, cell in enumerate(cells)]
        start = next((each for each in found if each is not None), None)
        try:
            return np.array([(x - start).total_seconds() if x and start else np.nan for x in found])
        except TypeError:
            raise BadInput(f"{self.path}: some time stamps name a time zone, some do not") from None

    def _skipped(self, line: str) -> bool:
        mark = self.rule.comment
        if leaves_out(self._skip, line):
            return True
        return not line.strip() or bool(mark and line.lstrip().startswith(mark))

    def _guessed(self, line: str) -> str:
        taken = "," if self.rule.decimal == "," else ""
        return next((each for each in GUESSES if each in line and each != taken), " ")

    def _cells(self, line: str) -> list[str]:
        if self.delimiter == " ":
            return line.split(maxsplit=COLUMNS)
        try:
            if line.count(self.delimiter) > COLUMNS:
                raise BadInput(f"{self.path}: has more than {COLUMNS} columns")
            return next(csv.reader([line], delimiter=self.delimiter), [])
        except csv.Error as error:
            raise BadInput(f"{self.path}: unreadable line {line!r:.60}: {error}") from None

    def _check_widths(self, width: int) -> None:
        """Every row has as many cells as there are names; one empty cell more ends a line."""
        if self.rule.ragged:
            return
        for row, line in enumerate(self.rows):
            plain = '"' not in line and self.delimiter != " "
            found = line.count(self.delimiter) + 1 if plain else len(self._cells(line))
            ended = found == width + 1 and line.rstrip(" \r").endswith(self.delimiter)
            if found != width and not ended:
                raise BadInput(
                    f"{self.place(row)}: expected {width} columns, got {found}; "
                    "text.ragged = true reads rows of unequal length, text.skip leaves lines out"
                )

    def _index(self, column: Column) -> int:
        if isinstance(column.name, int):
            width = len(self._cells(self.rows[0]))
            if column.name > width:
                raise BadInput(f"{self.path}: has {width} columns, none with number {column.name}")
            return column.name - 1
        found = [place for place, name in enumerate(self.names) if name == column.name]
        if len(found) != 1:
            raise BadInput(f"{self.path}: {absent(self.names, column.name, len(found))}")
        return found[0]

    @property
    def _dotted(self) -> Iterable[str]:
        if self.rule.decimal == ".":
            return self.rows
        return (line.replace(",", ".") for line in self.rows)

    def _column_cells(self, index: int) -> Iterator[str]:
        for line in self.rows:
            cells = self._cells(line)
            yield cells[index].strip() if index < len(cells) else ""

    def _of_cells(self, index: int) -> FloatArray:
        cells = self._column_cells(index)
        return np.array(array("d", (self._number(row, cell) for row, cell in enumerate(cells))))

    def _of_lists(self, index: int, place: int) -> FloatArray:
        """Numbers at `place` of lists in cells, such as `[0.1, 0.2]` or `0.1 0.2`."""
        values = array("d")
        for row, cell in enumerate(self._column_cells(index)):
            parts = [part for part in re.split(r"[\s,;]+", cell.strip("[](){} ")) if part]
            if cell in self.missing:
                values.append(np.nan)
            elif len(parts) < place:
                raise BadInput(
                    f"{self.place(row)}: {cell!r:.60} has {len(parts)} values, no number {place}"
                )
            else:
                values.append(self._number(row, parts[place - 1]))
        return np.array(values)

    def _number(self, row: int, cell: str) -> float:
        if cell in self.missing:
            return np.nan
        number = _as_number(cell.replace(",", ".") if self.rule.decimal == "," else cell)
        if np.isnan(number) and cell.strip("+-").lower() != "nan":
            advice = "list it under missing if it stands for no value"
            if "," in cell:
                advice = 'is its comma a decimal one? set text.decimal = ","'
            raise BadInput(f"{self.place(row)}: {cell!r:.60} is not a number; {advice}")
        return number

    def _stamp(self, row: int, cell: str, pattern: str) -> datetime | None:
        if cell in self.missing:
            return None
        try:
            return datetime.strptime(cell, pattern) if pattern else datetime.fromisoformat(cell)
        except ValueError:
            example = pattern or "2026-03-03 18:43:13.25"
            raise BadInput(
                f"{self.place(row)}: {cell!r:.60} is no time stamp such as {example}; "
                'give its form, as time.format = "%d.%m.%Y %H:%M:%S.%f"'
            ) from None


def absent(names: list[str], name: str, count: int) -> str:
    """Why a column of that name cannot be taken: there is none, or there are several."""
    if not names:
        return f'has no header to look "{name}" up in; give the number of the column'
    if count:
        return f'{count} columns are called "{name}"; give the number of one'
    return f'no column "{name}"{nearest(name, names)} (it has {", ".join(names):.300})'


def _as_number(text: str) -> float:
    try:
        return float(text) if "_" not in text else np.nan
    except ValueError:
        return np.nan


def _lines(path: Path, encoding: str) -> Iterator[str]:
    """Lines of a text file with their numbers checked for what no text holds."""
    name = "utf-8-sig" if encoding == "utf-8" else encoding
    advice = "; set text.encoding, such as latin-1"
    for number, line in enumerate(lines(path, name, advice=advice), start=1):
        if "\0" in line:
            raise BadInput(f"{path}, line {number}: holds a NUL character, this is no text")
        yield line
