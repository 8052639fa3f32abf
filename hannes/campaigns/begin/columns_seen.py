"""Every column of an unknown file, as it is recognised: name, unit, numbers."""

from collections import Counter
from pathlib import Path

import numpy as np

from hannes.campaigns.begin.column_guess import Seen
from hannes.campaigns.begin.text_layout import LIST, STAMP, TextLayout, number_of
from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.mapping import Column
from hannes.core.errors import BadInput

LOOKED_AT = 20  # cells of a column of texts


def text_columns(layout: TextLayout) -> list[Seen]:
    """Columns of a text file that hold numbers, lists of them, or stamps.

    A name that two columns share says nothing to a mapping: those are taken by number.
    """
    width = max(len(layout.names), len(layout.rows[0]))
    names = list(layout.names) or [""] * width
    counts = Counter(names)
    found = []
    for place, name in enumerate(names):
        cells = [row[place] if place < len(row) else "" for row in layout.rows]
        values = np.array([number_of(cell) for cell in cells])
        number = bool(np.isfinite(values).any())
        if not number and not _stamps_or_lists(cells):
            continue
        unit = layout.units[place] if place < len(layout.units) else ""
        column = name if name and counts[name] == 1 else place + 1
        found.append(Seen(column, name, unit, values if number else None))
    return found


def _stamps_or_lists(cells: list[str]) -> bool:
    known = [cell for cell in cells if cell][:LOOKED_AT]
    return any(STAMP.fullmatch(cell) or LIST.fullmatch(cell) for cell in known)


def array_columns(path: Path, source: object) -> list[Seen]:
    """Columns of a binary file."""
    if not isinstance(source, Arrays):
        raise BadInput(f"{path}: cannot be looked at; write a mapping (docs/reference/mapping.md)")
    found = []
    for name in source.names:
        try:
            values = source.numbers(Column(name))
        except BadInput:
            continue
        found.append(Seen(name, source.captions.get(name, name), "", values))
    return found
