"""Every column of an unknown file, as it is recognised: name, unit, numbers."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.column_guess import Seen
from hannes.campaigns.begin.text_layout import LIST, STAMP, TextLayout, number_of
from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.mapping import Column
from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

LOOKED_AT = 20  # cells of a column of texts


def text_columns(layout: TextLayout) -> list[Seen]:
    """Columns of a text file that hold numbers, lists of them, or stamps.

    A name that two columns share says nothing to a mapping: those are taken by number.
    """
    if layout.numbered:
        _require_one_clock(layout)
    width = max(len(layout.names), len(layout.rows[0]))
    names = list(layout.names) or [""] * width
    counts = Counter(names)
    found = []
    for place, name in enumerate(names):
        cells = [row[place] if place < len(row) else "" for row in layout.rows]
        values = np.array([number_of(cell) for cell in cells])
        number = bool(np.isfinite(values).any())
        if layout.numbered and place > 0 and place % 2 == 0:
            continue  # the same clock again
        if not number and not _stamps_or_lists(cells):
            continue
        unit = layout.units[place] if place < len(layout.units) else ""
        named = name and counts[name] == 1 and not layout.numbered
        column = name if named else place + 1
        found.append(Seen(column, name, unit, values if number else None))
    return found


def _require_one_clock(layout: TextLayout) -> None:
    """Each channel has its own column of times; they must be the same."""
    for row in layout.rows:
        if len(set(row[::2])) > 1:
            times = ", ".join(row[::2])[:80]
            raise BadInput(f"each channel has a clock of its own ({times}); export one time base")


def _stamps_or_lists(cells: list[str]) -> bool:
    known = [cell for cell in cells if cell][:LOOKED_AT]
    return any(STAMP.fullmatch(cell) or LIST.fullmatch(cell) for cell in known)


@dataclass(frozen=True)
class SeenArrays:
    """Columns of a binary file.

    stacked: names of arrays (runs, n) whose rows are runs; left: arrays of which nobody can see
    what their axes are, with their shapes.
    """

    columns: list[Seen]
    stacked: list[str]
    left: list[str]


def array_columns(path: Path, source: object) -> SeenArrays:
    """Look at a binary file: arrays (n,), and of those (runs, n) beside them the first run."""
    if not isinstance(source, Arrays):
        raise BadInput(f"{path}: cannot be looked at; write a mapping (docs/reference/mapping.md)")
    tables = {}
    found = SeenArrays([], [], [])
    for name in source.names:
        try:
            tables[name] = source.table(Column(name))
        except BadInput:
            shape = np.shape(source.read(name))
            if len(shape) > 2:
                found.left.append(f"{name} {shape}")
            continue
    lengths = {each.size for each in tables.values() if each.ndim == 1}
    for name, table in tables.items():
        if table.ndim == 2 and (table.shape[1] not in lengths or table.shape[0] >= table.shape[1]):
            found.left.append(f"{name} {table.shape}")
        elif table.ndim == 2:
            found.stacked.append(name)
            found.columns.append(_seen(source, name, table[0]))
        elif table.size > 1:  # one number is a setting
            found.columns.append(_seen(source, name, table))
    return found


def _seen(source: Arrays, name: str, values: FloatArray) -> Seen:
    return Seen(name, source.captions.get(name, name), source.units.get(name, ""), values)
