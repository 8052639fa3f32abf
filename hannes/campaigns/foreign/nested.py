"""Records such as {"motor": {"current": 0.1}, "q": [0.2, 0.3]} as columns motor/current, q/1, q/2.

A value that a record lacks is missing (NaN) there; texts and nulls are missing too. Of a text that
is a date and time the seconds since 1970 are taken, in UTC where it names no zone.
"""

import re
from array import array
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput
from hannes.core.io.limits import COLUMNS, table_fits

FloatArray = NDArray[np.float64]

DEEPEST = 8  # levels of nesting
MISSING = float("nan")
STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")


def flat(record: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, float]]:
    """Numbers of one record by path; items of lists count from 1."""
    if isinstance(record, bool | int | float | np.number):
        yield prefix, as_float(record)
    elif isinstance(record, str):
        if STAMP.match(record) and (seconds := _seconds(record)) is not None:
            yield prefix, seconds
    elif isinstance(record, dict) and depth < DEEPEST:
        for key, value in record.items():
            yield from flat(value, f"{prefix}/{key}" if prefix else str(key), depth + 1)
    elif isinstance(record, list | tuple | np.ndarray) and depth < DEEPEST:
        for place, value in enumerate(record, start=1):
            yield from flat(value, f"{prefix}/{place}" if prefix else str(place), depth + 1)


def _seconds(text: str) -> float | None:
    try:
        stamp = datetime.fromisoformat(text)
        return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        return None


def as_float(value: Any) -> float:
    """A number as float64, infinite where it is too large for that."""
    try:
        return float(value)
    except OverflowError:
        return float("inf")


class Records:
    """Records one after another, as columns; `decoded` bytes of the file were read for them."""

    def __init__(self, where: str, decoded: int) -> None:
        self.where, self.decoded = where, decoded
        self._columns: dict[str, array[float]] = {}
        self._count = 0

    def add(self, record: Any) -> None:
        """Add one record; BadInput for more columns than COLUMNS, or out of all proportion."""
        for name, value in flat(record):
            column = self._columns.get(name)
            if column is None:
                column = self._columns[name] = array("d")
                if len(self._columns) > COLUMNS:
                    raise BadInput(
                        f"{self.where}: more than {COLUMNS} columns; this is no log of samples"
                    )
            self._fill(column, self._count)
            column[self._count :] = array("d", (value,))
        self._count += 1
        self._require_in_proportion()

    def _fill(self, column: "array[float]", count: int) -> None:
        if len(column) < count:
            column.extend(array("d", (MISSING,)) * (count - len(column)))

    def _require_in_proportion(self) -> None:
        if not table_fits(self._count, len(self._columns), self.decoded):
            raise BadInput(
                f"{self.where}: {len(self._columns)} columns of {self._count} rows, most of them "
                "empty, are too large; cut it into parts"
            )

    def columns(self) -> dict[str, FloatArray]:
        """Columns by path, shape (n,) each."""
        for column in self._columns.values():
            self._fill(column, self._count)
        return {name: np.frombuffer(column) for name, column in self._columns.items()}


def columns(records: Iterable[Any], where: str, decoded: int) -> dict[str, FloatArray]:
    """Columns (n,) of n records; BadInput for too many of them, see `Records`."""
    found = Records(where, decoded)
    for record in records:
        found.add(record)
    return found.columns()
