"""How an unknown text file is laid out: encoding, delimiter, decimal mark, header, numbers."""

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hannes.campaigns.begin.channel_words import plain
from hannes.campaigns.begin.property_rows import paired, units_above
from hannes.campaigns.begin.serial_guess import form_of
from hannes.campaigns.foreign.nested import as_float
from hannes.campaigns.foreign.serial_lines import STAMP as STAMP_NAME
from hannes.campaigns.foreign.serial_lines import SerialForm
from hannes.campaigns.foreign.spelled_units import are_units
from hannes.core.errors import BadInput
from hannes.core.io.bounded import lines as read_lines
from hannes.core.io.bounded import opened

LOOKED_AT = 5000  # lines
LONGEST = 20_000  # characters of a line that are looked at
FEWEST = 3  # lines of numbers
DELIMITERS = {"tab": "\t", "semicolon": ";", "comma": ",", "|": "|", "space": " "}
MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--"}
NUMBER = re.compile(r"[+-]?(\d+([.]\d*)?|[.]\d+)([eE][+-]?\d+)?|[+-]?inf|0[xX][0-9a-fA-F]+")
STAMP = re.compile(
    r"\d{1,4}[-/.:]\d{1,2}[-/.:]\d{1,4}([ T]\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?|[.,]\d+)?Z?"
)
LIST = re.compile(r"[\[(]\s*[+-]?[\d.].*[\])]")
REMARKS = ("", "comment", "comments", "note", "notes", "remark", "remarks", "kommentar",
           "bemerkung", "commentaire", "commento", "comentario")  # fmt: skip
MARKS = ("#", "%", "//", ";", "[")


@dataclass(frozen=True)
class TextLayout:
    """Layout of a text file; line numbers from 1.

    names, units: of the columns, as far as header lines say; rows: some lines of numbers, as
    cells; samples: the same as they stand; blanks, headers: whether blank lines or repeated headers
    stand between numbers; odd: other lines there; ragged: whether rows have unequal length;
    missing: texts for no value; form: of a serial monitor's lines;
    numbered: whether columns are pairs of time and value, whose names stand in no one line.
    """

    encoding: str
    delimiter: str
    decimal: str
    comment: str
    header: int
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...] = field(repr=False)
    blanks: bool
    headers: bool
    odd: tuple[str, ...]
    ragged: bool
    missing: tuple[str, ...]
    numbered: bool = False
    form: SerialForm | None = None
    samples: tuple[str, ...] = field(default=(), repr=False)


def text_layout(path: Path) -> TextLayout:
    """Look at the beginning of a text file; BadInput where it holds no rows of numbers."""
    encoding = _encoding(path)
    name = "utf-8-sig" if encoding == "utf-8" else encoding
    lines = [line[:LONGEST] for line in itertools.islice(read_lines(path, name), LOOKED_AT)]
    form = form_of(lines, lambda rests: DELIMITERS[_cut(rests, path)[0]])
    if form is not None:
        lines = _plain(form, lines)
    delimiter, decimal = _cut(lines, path)
    cells = [_cells(line, DELIMITERS[delimiter], decimal) for line in lines]
    places = [k for k, row in enumerate(cells) if _is_numbers(row)]
    width = Counter(len(cells[k]) for k in places).most_common(1)[0][0]
    first = next(k for k in places if len(cells[k]) == width)
    header, comment = _header(lines, cells, first, width)
    between = range(first, places[-1] + 1)
    odd = [lines[k] for k in between if lines[k].strip() and not _is_numbers(cells[k])]
    again = lines[header - 1] if header else None
    widths = {len(_ended(cells[k], width)) for k in places if k >= first}
    rows = [tuple(_ended(cells[k], width)) for k in places if k >= first]
    names, units = _names(cells, header, first, comment)
    pairs = paired(cells, first, width)
    if pairs is not None:
        header, (names, units) = 0, pairs
    if form is not None and form.mark:
        header, first, odd = 0, 0, []
    samples = [lines[k] for k in places if k >= first]
    if form is not None and form.stamped and not form.mark:
        samples = [line.partition(form.delimiter)[2] for line in samples]
        names = (STAMP_NAME, *names[1:]) if names else ()
        odd = [line.partition(form.delimiter)[2] for line in odd]
        again = again.partition(form.delimiter)[2] if again else None
    return TextLayout(
        encoding,
        delimiter,
        decimal,
        comment,
        header,
        first + 1,
        names,
        units,
        tuple(rows),
        any(not lines[k].strip() for k in between) and not (form and form.mark),
        again in odd,
        tuple(line for line in odd if line != again),
        len(widths) > 1 or (width < len(names) and _are_remarks(names[width:])),
        tuple(sorted({cell for row in rows for cell in row if _is_missing(cell) and cell})),
        pairs is not None,
        form,
        tuple(samples),
    )


def _plain(form: SerialForm, lines: Sequence[str]) -> list[str]:
    """Lines of a serial monitor as cells; with names in each line, those above all."""
    plain = [form.plain(line) for line in lines]
    if form.mark:
        return [form.head, *(line for line in plain if line is not None)]
    return [line or "" for line in plain]


def _are_remarks(names: Sequence[str]) -> bool:
    """Whether names without cells below them are of remarks; others could shift all columns."""
    return all(plain(name) in REMARKS for name in names)


def _encoding(path: Path) -> str:
    """UTF-16 by its mark, UTF-8 where the beginning is that, else Latin-1."""
    with opened(path, "a log of samples") as file:
        if file.read(2) in (b"\xff\xfe", b"\xfe\xff"):
            return "utf-16"
    try:
        for _ in itertools.islice(read_lines(path), LOOKED_AT):
            pass
    except BadInput:
        return "latin-1"
    return "utf-8"


def _cut(lines: Sequence[str], path: Path) -> tuple[str, str]:
    """Delimiter and decimal mark by which most lines become equally long rows of numbers."""
    best, found = 0.0, ("", "")
    for name, mark in DELIMITERS.items():
        for decimal in (".", ",") if mark != "," else (".",):
            rows = [_cells(line, mark, decimal) for line in lines]
            widths = Counter(len(row) for row in rows if _is_numbers(row))
            if not widths:
                continue
            width, count = widths.most_common(1)[0]
            score = count * (1.0 + 0.1 * min(width, 5)) if width > 1 else 0.5 * count
            if score > 1.05 * best and count >= FEWEST:
                best, found = score, (name, decimal)
    if not best:
        raise BadInput(f"{path}: no {FEWEST} lines of numbers in it; is it a log of samples?")
    return found


def _cells(line: str, delimiter: str, decimal: str) -> list[str]:
    """Cells of a line, as numbers are written with a point."""
    if delimiter == " ":
        cells = line.split()
    elif '"' in line:
        import csv

        try:
            cells = next(csv.reader([line], delimiter=delimiter), [])
        except csv.Error:
            cells = line.split(delimiter)
    else:
        cells = line.split(delimiter)
    cells = [cell.strip() for cell in cells]
    if decimal == ",":
        return [cell.replace(",", ".") if _german(cell) else cell for cell in cells]
    return cells


def _german(cell: str) -> bool:
    return bool(re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?|[+-]?\d+", cell))


def _is_missing(cell: str) -> bool:
    return cell.lower() in MISSING


def is_number(cell: str) -> bool:
    """Whether a cell is a number."""
    return bool(NUMBER.fullmatch(cell))


def number_of(cell: str) -> float:
    """Value of a cell, NaN where it is no number."""
    if not is_number(cell):
        return float("nan")
    return as_float(int(cell, 16)) if cell[1:2] in ("x", "X") else float(cell)


def _is_numbers(cells: Sequence[str]) -> bool:
    """Whether a row holds samples: numbers and stamps, more than half of it, and one at least.

    Half is enough where a stamp or number stands first: time, signal, value, unit.
    """
    numbers = sum(_is_value(cell) for cell in cells)
    known = numbers + sum(_is_missing(cell) for cell in cells)
    least = len(cells) if cells and _is_value(cells[0]) else len(cells) + 1
    return numbers > 0 and (known == len(cells) or (numbers >= 2 and 2 * known >= least))


def _is_value(cell: str) -> bool:
    return is_number(cell) or bool(STAMP.fullmatch(cell) or LIST.fullmatch(cell))


def _ended(cells: Sequence[str], width: int) -> Sequence[str]:
    """Without the empty cell that a delimiter at the line's end leaves."""
    return cells[:width] if len(cells) == width + 1 and not cells[-1] else cells


def _header(
    lines: Sequence[str], cells: Sequence[Sequence[str]], first: int, width: int
) -> tuple[int, str]:
    """Number of the line with the names (0: none), and the mark with which it begins.

    Names, symbols and units may stand in lines one above the other: names are the longest.
    """
    found: list[tuple[int, int]] = []
    for k in range(first - 1, max(first - 6, -1), -1):
        words = [cell for cell in cells[k] if cell]
        fits = max(2 if width > 1 else 1, 0.6 * width) <= len(words) <= width + 2
        if not fits or any(is_number(cell) for cell in words):
            if found and words:
                break
            continue
        found.append((sum(map(len, words)) if not are_units(cells[k]) else 0, -k))
    if not found:
        return 0, ""
    k = -max(found)[1]
    mark = next((m for m in MARKS if lines[k].lstrip().startswith(m)), "")
    return k + 1, mark if mark not in ("[", ";") else ""


def _names(
    cells: Sequence[Sequence[str]], header: int, first: int, comment: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the columns, and units from a line between names and numbers."""
    if not header:
        return (), ()
    names = list(cells[header - 1])
    if comment and names:
        names[0] = names[0].removeprefix(comment).strip()
        names = names[1:] if not names[0] and len(names) > len(cells[first]) else names
    for k in range(header, first):
        if len(cells[k]) >= len(names) and are_units(
            [cell.removeprefix(comment) for cell in cells[k]]
        ):
            units = [cell.removeprefix(comment).strip(" ()[]") for cell in cells[k]]
            return tuple(names), tuple(units[: len(names)])
    return tuple(names), units_above(cells, header, len(names))
