"""Rows of properties above the numbers of a text file, such as names and units of its channels.

LabVIEW writes `Y_Unit_Label`, then a cell a column. TwinCAT writes `Unit` before each cell, and
gives each channel a column of times and one of values.
"""

from collections.abc import Sequence

from hannes.campaigns.begin.channel_words import plain
from hannes.campaigns.foreign.spelled_units import are_units

UNITS = ("unit", "units", "y_unit_label", "einheit", "einheiten", "unita", "unite", "unidad")
NAMES = ("name", "signal", "channel", "symbolname")
LOOKED_AT = 60  # rows above the numbers
CLOCK = "Time"


def units_above(cells: Sequence[Sequence[str]], header: int, width: int) -> tuple[str, ...]:
    """Units by column from a row above the names (line `header`) that says what it is, or none."""
    for row in reversed(cells[max(header - LOOKED_AT, 0) : header - 1]):
        if row and plain(row[0].strip(" :#%")) in UNITS and len(row) <= width + 1:
            if are_units(row[1:]):
                return ("", *row[1:width])
    return ()


def paired(
    cells: Sequence[Sequence[str]], first: int, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Names and units of columns in pairs of time and value, None where rows say no such thing."""
    found: dict[str, list[str]] = {}
    for row in cells[max(first - LOOKED_AT, 0) : first]:
        labels = set(row[::2])
        if width >= 4 and width % 2 == 0 and len(row) == width and len(labels) == 1:
            found.setdefault(plain(row[0]), list(row[1::2]))
    names = next((found[key] for key in NAMES if key in found), None)
    if names is None:
        return None
    units = next((found[key] for key in UNITS if key in found), [""] * len(names))
    return _alternating([CLOCK] * len(names), names), _alternating([""] * len(names), units)


def _alternating(one: Sequence[str], other: Sequence[str]) -> tuple[str, ...]:
    return tuple(each for pair in zip(one, other, strict=True) for each in pair)
