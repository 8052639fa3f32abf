"""Runs that lie side by side in arrays of two axes: each row along the clock is a run."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.mapping import Column
from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]


class Stacked:
    """Arrays (runs, n) or (n, runs) beside others (n,), which all runs share, as one long table.

    n is the length of the clock, else of the longer axis.
    """

    def __init__(self, source: Arrays, columns: Iterable[Column], clock: Column | None) -> None:
        self.source, self.path = source, source.path
        tables = {column: source.table(column) for column in columns}
        wide = [table for table in tables.values() if table.ndim == 2]
        if not wide:
            raise BadInput(f'{self.path}: split_at = "stacked": no mapped array has two axes')
        own = source.table(clock) if clock is not None else wide[0]
        self.size = own.size if own.ndim == 1 else max(own.shape)
        self.count = wide[0].size // max(self.size, 1)
        for column, table in tables.items():
            if table.ndim == 2:
                self._require(column, table)

    def _require(self, column: Column, table: FloatArray) -> None:
        fits = sorted(table.shape) == sorted((self.count, self.size))
        if not fits or table.shape[0] == table.shape[1]:
            raise BadInput(
                f'{self.path}: "{column.name}" has the shape {table.shape}; expected '
                f"{self.count} runs of {self.size} samples, in whichever order"
            )

    def numbers(self, column: Column) -> FloatArray:
        """All runs one after another, shape (runs * n,); what they share is repeated."""
        table = self.source.table(column)
        if table.ndim == 2:
            return np.ravel(table if table.shape[1] == self.size else table.T)
        return np.tile(table, self.count) if table.size == self.size else table

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Arrays hold numbers."""
        return self.source.stamps(column, pattern)

    def labels(self, column: Column) -> FloatArray:
        """The numbers themselves."""
        return self.numbers(column)

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """First rows of all runs but the first."""
        return np.arange(1, self.count, dtype=np.intp) * self.size

    def place(self, row: int) -> str:
        """File, run and sample of a row, as messages show them."""
        return f"{self.path}, run {row // self.size + 1}, sample {row % self.size + 1}"
