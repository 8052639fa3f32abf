"""Records such as {"motor": {"current": 0.1}, "q": [0.2, 0.3]} as columns motor/current, q/1, q/2.

A value that a record lacks is missing (NaN) there; texts and nulls are missing too.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.core.errors import BadInput

FloatArray = NDArray[np.float64]

DEEPEST = 8  # levels of nesting
MOST_COLUMNS = 2000


def flat(record: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, float]]:
    """Numbers of one record by path; items of lists count from 1."""
    if isinstance(record, bool | int | float | np.number):
        yield prefix, float(record)
    elif isinstance(record, dict) and depth < DEEPEST:
        for key, value in record.items():
            yield from flat(value, f"{prefix}/{key}" if prefix else str(key), depth + 1)
    elif isinstance(record, list | tuple | np.ndarray) and depth < DEEPEST:
        for place, value in enumerate(record, start=1):
            yield from flat(value, f"{prefix}/{place}" if prefix else str(place), depth + 1)


def columns(records: Iterable[Any], where: str) -> dict[str, FloatArray]:
    """Columns (n,) of n records; BadInput for more than MOST_COLUMNS of them."""
    found: dict[str, dict[int, float]] = {}
    count = 0
    for count, record in enumerate(records, start=1):
        for name, value in flat(record):
            found.setdefault(name, {})[count - 1] = value
        if len(found) > MOST_COLUMNS:
            raise BadInput(f"{where}: more than {MOST_COLUMNS} columns; this is no log of samples")
    return {name: _filled(values, count) for name, values in found.items()}


def _filled(values: dict[int, float], count: int) -> FloatArray:
    column = np.full(count, np.nan)
    column[list(values)] = list(values.values())
    return column
