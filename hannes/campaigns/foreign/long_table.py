"""Long tables, a row a value (time, name of the signal, value), turned wide: a row a time."""

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import Arrays
from hannes.campaigns.foreign.mapping import Column, LongRule, TimeRule
from hannes.campaigns.foreign.text_columns import Delimited
from hannes.core.errors import BadInput, nearest

FloatArray = NDArray[np.float64]


class Wide:
    """Signals of a long table as columns, NaN where one has no value at a time."""

    def __init__(
        self, source: Arrays | Delimited, rule: LongRule, clock: TimeRule, split: Column | None
    ) -> None:
        self.source, self.path, self.clock = source, source.path, clock
        if clock.column is None:
            raise BadInput(f"{self.path}: a long table needs a column of times")
        ticks = self._ticks(clock.column)
        self._texts, self._values = source.texts(rule.names), source.numbers(rule.values)
        runs = source.labels(split) if split is not None else np.zeros(ticks.size)
        sizes = {ticks.size, self._values.size, self._texts.codes.size, runs.size}
        if len(sizes) > 1:
            raise BadInput(f"{self.path}: times, names and values of the long table differ in rows")
        order = np.lexsort((ticks, runs))
        fresh = (np.diff(ticks[order]) != 0.0) | (np.diff(runs[order]) != 0.0)
        fresh = np.concatenate(([True], fresh))
        self._first = order[fresh]
        self._place = np.empty(ticks.size, np.intp)
        self._place[order] = np.cumsum(fresh) - 1
        self.names, self._all_ticks, self._runs = self._texts.names, ticks, runs

    def _ticks(self, column: Column) -> FloatArray:
        if self.clock.iso:
            return self.source.stamps(column, self.clock.pattern)
        return self.source.numbers(column)

    def numbers(self, column: Column) -> FloatArray:
        """Values of one signal at all times (n,), or the times themselves."""
        if column == self.clock.column:
            return self._all_ticks[self._first]
        if column.name not in self.names or column.index:
            hint = nearest(str(column.name), self.names)
            shown = ", ".join(self.names)
            raise BadInput(f'{self.path}: no signal "{column.name}"{hint} (it has {shown:.300})')
        rows = np.flatnonzero(self._texts.codes == self.names.index(str(column.name)))
        places = self._place[rows]
        if np.unique(places).size < places.size:
            raise BadInput(
                f'{self.path}: "{column.name}" has several values at one time; where runs follow '
                "each other, name the column that numbers them as split"
            )
        found = np.full(self._first.size, np.nan)
        found[places] = self._values[rows]
        return found

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """The different times [s], in order."""
        return self._all_ticks[self._first]

    def labels(self, column: Column) -> FloatArray:
        """Numbers of the runs."""
        return self._runs[self._first]

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """A long table is sorted by time."""
        raise BadInput(f'{self.path}: split_at = "{kind}" is not of long tables; use split')

    def place(self, row: int) -> str:
        """Where the first value of a time stands, for messages."""
        return self.source.place(int(self._first[row]))
