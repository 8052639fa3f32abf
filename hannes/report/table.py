"""A table as a page prints it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """`rows` hold one text for each of `columns`; the first cell of a row is its heading."""

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
