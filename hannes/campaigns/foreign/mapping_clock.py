"""Columns, clocks, text and further files of a mapping, from its TOML tables."""

from datetime import datetime
from typing import Any

from hannes.campaigns.foreign.mapping import ORDERS, Column, FurtherFile, TextRule, TimeRule
from hannes.campaigns.foreign.skip_pattern import skip_pattern
from hannes.core.errors import BadInput, nearest
from hannes.core.io import units
from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity

TEXT = (
    "delimiter", "decimal", "comment", "header", "first", "encoding", "skip", "ragged",
    "stamped", "pairs",
)  # fmt: skip
TIME = (
    "column", "index", "unit", "format", "sampling", "offset", "from_zero", "resample", "wrap",
    "order", "repeats", "cut",
)  # fmt: skip
FURTHER = ("replace", "by", "time")
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
ENCODINGS = ("utf-8", "latin-1", "utf-16")
MOST_LINES = 10**9
FASTEST = 1e7  # Hz


def column_of(table: Table) -> Column:
    """The column that a table names, by its name or its number from 1."""
    table.require("column", '"name of the column", or its number')
    name = name_or_number(table, "column")
    return Column(name, table.whole("index", 1, MOST_LINES) if "index" in table else 0)


def name_or_number(table: Table, key: str) -> str | int:
    """A column's name, or its number from 1."""
    name = table.content[key]
    if isinstance(name, int) and not isinstance(name, bool) and name >= 1:
        return name
    if not isinstance(name, str) or not name:
        table.refuse(key, "must be the name of a column in quotes, or its number from 1")
    return name


def unit_factor(table: Table, wanted: str) -> float:
    """Worth of the column's unit in the unit that the plant declares."""
    table.require("unit", f'"{wanted}"')
    given = table.text("unit", "")
    try:
        return units.unit_scale(given, wanted)
    except BadInput as error:
        table.refuse("unit", f'= "{given[:60]}" cannot be used: {error}')


def above_zero(table: Table, key: str) -> float:
    """A number above zero, of raw values."""
    value = quantity(table.content[key], "1", table.name(key))
    if not 0.0 < value <= 2.0**64:
        table.refuse(key, f"= {value:g}: expected a number above zero")
    return value


def time_rule(root: Table) -> TimeRule:
    """The clock of a file: a column, or a sampling rate."""
    root.require("time", '{ column = "t", unit = "s" }, or { sampling = "1 kHz" }')
    table = root.table("time", TIME)
    if ("column" in table) == ("sampling" in table):
        table.refuse("column", "or sampling: expected one of the two, the clock of the recording")
    for key in ("index", "unit", "format", "from_zero", "wrap", "order"):
        if "sampling" in table and key in table:
            table.refuse(key, "belongs to a time column, not to a sampling rate")
    pattern = _pattern(table)
    iso = bool(pattern) or table.text("format", "number") == "iso"
    if iso and "unit" in table:
        table.refuse("unit", "does not go with a format of dates: such stamps carry their unit")
    return TimeRule(
        column_of(table) if "column" in table else None,
        1.0 if iso or "sampling" in table else unit_factor(table, "s"),
        _rate(table, "sampling"),
        iso,
        iso or table.flag("from_zero"),
        table.quantity("offset", "s") if "offset" in table else 0.0,
        _rate(table, "resample"),
        pattern,
        above_zero(table, "wrap") if "wrap" in table else 0.0,
        table.choice("order", ORDERS, "refuse"),
        table.choice("repeats", ("keep", "drop"), "keep") == "keep",
        _cut(table),
    )


def _cut(table: Table) -> tuple[tuple[float, float], ...]:
    """Stretches to be left out [s], such as cut = [["0.41 s", "0.52 s"]]."""
    found = []
    for pair in table.items("cut"):
        if not isinstance(pair, list) or len(pair) != 2:
            table.refuse("cut", 'must be a list of pairs, such as [["0.41 s", "0.52 s"]]')
        start, end = (quantity(each, "s", table.name("cut")) for each in pair)
        if not start <= end:
            table.refuse("cut", f"ends at {end:g} s before it begins at {start:g} s")
        found.append((start, end))
    return tuple(found)


def _pattern(table: Table) -> str:
    """The form of time stamps as of strptime, where `format` is neither number nor iso."""
    given = table.text("format", "number")
    if given in ("number", "iso"):
        return ""
    if "%" not in given:
        table.refuse(
            "format", f'= "{given[:60]}": expected number, iso, or a form such as %H:%M:%S'
        )
    try:
        datetime.strptime(datetime(2026, 3, 3).strftime(given), given)
    except Exception as error:  # strptime makes a regular expression of it, and lets its faults out
        table.refuse("format", f'= "{given[:60]}" cannot be used: {error}')
    return given


def _rate(table: Table, key: str) -> float:
    """Return a sampling rate [Hz], 0 where the key is absent."""
    if key not in table:
        return 0.0
    rate = table.quantity(key, "Hz", "1 kHz")
    if not 0.0 < rate <= FASTEST:
        table.refuse(key, f"= {rate:g} Hz: expected more than 0 and at most {FASTEST:g} Hz")
    return rate


def text_rule(root: Table) -> TextRule:
    """How lines of text are divided."""
    table = root.table("text", TEXT)
    header = table.whole("header", 0, MOST_LINES, 0 if "pairs" in table else 1)
    first = table.whole("first", 1, MOST_LINES, header + 1)
    if first <= header:
        table.refuse("first", f"= {first}: numbers start below the header in line {header}")
    decimal = table.choice("decimal", (".", ","), ".")
    delimiter = _delimiter(table)
    if decimal == delimiter == ",":
        table.refuse("decimal", "and delimiter are both a comma: nothing distinguishes them")
    return TextRule(
        delimiter,
        decimal,
        table.text("comment", ""),
        header,
        first,
        table.choice("encoding", ENCODINGS, "utf-8"),
        skip_pattern(table, "skip"),
        table.flag("ragged"),
        *_serial(table, delimiter, header),
    )


def _serial(table: Table, delimiter: str, header: int) -> tuple[bool, str]:
    """Stamps of a serial monitor, and the mark between names and values."""
    stamped, mark = table.flag("stamped"), table.text("pairs", "")
    if (stamped or mark) and not delimiter:
        table.refuse("delimiter", "is missing: it goes with stamped and with pairs")
    if mark and header:
        table.refuse("header", "does not go with pairs: each value has its name")
    if mark and (len(mark) > 1 or mark == delimiter):
        table.refuse("pairs", 'must be the one character between name and value, such as ":"')
    return stamped, mark


def _delimiter(table: Table) -> str:
    given = table.content.get("delimiter", "")
    if not isinstance(given, str):
        table.refuse("delimiter", f"must be in quotes: one character, or {', '.join(DELIMITERS)}")
    found = DELIMITERS.get(given, given)
    if len(found) > 1 or found in ('"', "\n", "\r"):
        hint = nearest(given, DELIMITERS)
        table.refuse("delimiter", f"must be one character, or {', '.join(DELIMITERS)}{hint}")
    return found


def further_files(root: Table) -> dict[str, FurtherFile]:
    """Further files of a run, by the name that channels give as `from`."""
    tables = root.table("files", ())
    found = {name: _further(tables.table(name, FURTHER)) for name in tables.content}
    channels: dict[str, Any] = root.content.get("channels", {})
    asked = {each.get("from", "") for each in channels.values() if isinstance(each, dict)} - {""}
    if unknown := sorted(map(str, asked - found.keys())):
        root.refuse("channels", f'name from = "{unknown[0]}", but there is no [files.{unknown[0]}]')
    if unused := sorted(found.keys() - asked):
        root.refuse("files", f'"{unused[0]}" is named as from by no channel')
    return found


def _further(table: Table) -> FurtherFile:
    for key, example in (("replace", "state"), ("by", "control")):
        table.require(key, f'"{example}"')
    replace = table.text("replace", "")
    if not replace:
        table.refuse("replace", "is empty: expected a part of the first file's name")
    if "/" in (by := table.text("by", "")):
        table.refuse("by", "must be part of a name: further files lie beside the first")
    return FurtherFile(replace, by, time_rule(table))
