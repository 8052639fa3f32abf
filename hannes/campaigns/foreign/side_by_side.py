"""Runs that lie side by side in one file: columns whose paths differ by a name or a number.

A column `runs/*/time` stands for `runs/1/time`, `runs/2/time` and so on, a run each.
"""

import re
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import Arrays, as_path
from hannes.campaigns.foreign.mapping import Column
from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

STAR = "*"
MOST_STARS = 3  # in a column, runs within runs
Run = tuple[str, ...]  # what stands for each star


class SideBySide:
    """Columns with stars as one long table, run after run; those without are shared by all.

    A star that is a whole part of a path stands for any name, one beside letters for digits.
    """

    def __init__(self, source: Arrays, columns: Iterable[Column]) -> None:
        self.source, self.path = source, source.path
        starred = [each for each in columns if is_starred(source, each)]
        if many := next((x for x in starred if str(x.name).count(STAR) > MOST_STARS), None):
            raise BadInput(f'{self.path}: "{many.name}" has more than {MOST_STARS} stars')
        self.runs = self._found(starred)
        lengths = [[self._values(each, run).size for run in self.runs] for each in starred]
        for column, own in zip(starred, lengths, strict=True):
            for run, size, expected in zip(self.runs, own, lengths[0], strict=True):
                if size != expected:
                    raise BadInput(
                        f'{self.path}: "{_named(column, run)}" has {size} samples, '
                        f'"{_named(starred[0], run)}" has {expected}: map those of one logger'
                    )
        self.sizes = lengths[0]
        self._ends = np.cumsum(self.sizes)

    def _found(self, columns: list[Column]) -> list[Run]:
        """What the stars stand for; each run must have every column."""
        found = [_matches(str(each.name), self.source.names) for each in columns]
        every = sorted({run for runs in found for run in runs}, key=in_order)
        if not every:
            raise BadInput(f'{self.path}: holds nothing like "{columns[0].name}"')
        for column, runs in zip(columns, found, strict=True):
            if lacking := [run for run in every if run not in runs]:
                raise BadInput(
                    f'{self.path}: holds no "{_named(column, lacking[0])}", though other columns '
                    "have that run: leave the channel out, or name one run without *"
                )
        return every

    def _values(self, column: Column, run: Run) -> FloatArray:
        return self.source.numbers(Column(_named(column, run), column.index))

    def numbers(self, column: Column) -> FloatArray:
        """Values of all runs one after another, shape (n,); what they share is repeated."""
        if is_starred(self.source, column):
            return np.concatenate([self._values(column, run) for run in self.runs])
        shared = self.source.numbers(column)
        if any(size != shared.size for size in self.sizes):
            raise BadInput(
                f'{self.path}: "{column.name}" has {shared.size} samples, the runs beside it have '
                f"{min(self.sizes)} to {max(self.sizes)}"
            )
        return np.tile(shared, len(self.runs))

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Arrays hold numbers."""
        return self.source.stamps(column, pattern)

    def labels(self, column: Column) -> FloatArray:
        """The numbers themselves."""
        return self.numbers(column)

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """First rows of all runs but the first."""
        return np.asarray(self._ends[:-1], np.intp)

    def place(self, row: int) -> str:
        """File, run and sample of a row, as messages show them."""
        run = int(np.searchsorted(self._ends, row, side="right"))
        start = int(self._ends[run] - self.sizes[run])
        return f"{self.path}, run {'/'.join(self.runs[run])}, sample {row - start + 1}"


def is_starred(source: Arrays, column: Column) -> bool:
    """Whether a column has a star that is no part of a name."""
    return STAR in str(column.name) and column.name not in source.names


def _named(column: Column, run: Run) -> str:
    """The path of one run's column."""
    name = str(column.name)
    for each in run:
        name = name.replace(STAR, each, 1)
    return name


def _matches(name: str, names: Sequence[str]) -> set[Run]:
    """What the stars of a path may stand for; as MATLAB writes it, where it is none as it is."""
    parts = [
        "([^/]+)" if part == STAR else re.escape(part).replace(re.escape(STAR), r"(\d+)")
        for part in name.split("/")
    ]
    pattern = re.compile("/".join(parts))
    runs = {found.groups() for each in names if (found := pattern.fullmatch(each))}
    path = as_path(name)
    return runs if runs or path == name else _matches(path, names)


def in_order(run: Run) -> list[tuple[int, str]]:
    """Sort key: numbers by their size, within names too."""
    pieces = [piece for each in run for piece in re.split(r"(\d+)", each)]
    return [(int(each), "") if each.isdecimal() else (-1, each) for each in pieces]
