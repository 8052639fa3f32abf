"""Equality by value of what holds arrays, for which a dataclass' own == knows no answer."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, cast

import numpy as np


class ByValue:
    """Equal where type and all compared fields are; arrays element by element, nan like nan."""

    def compared(self) -> tuple[Any, ...]:
        """What counts in ==: fields that do not say `compare=False`; all where it has no fields."""
        if not is_dataclass(type(self)):
            return (vars(self),)
        declared = fields(cast(Any, type(self)))
        return tuple(getattr(self, each.name) for each in declared if each.compare)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        assert isinstance(other, ByValue)
        return self is other or same(self.compared(), other.compared())

    __hash__: Any = None


def same(one: Any, other: Any) -> bool:
    """Whether two values are equal, arrays within them by shape and elements, nan like nan."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _same_arrays(one, other)
    if type(one) is not type(other):
        return bool(one == other)
    if isinstance(one, ByValue):
        return bool(one == other)
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(same(one[name], other[name]) for name in one)
    if isinstance(one, Sequence) and not isinstance(one, str | bytes):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other) or (one != one and other != other)


def _same_arrays(one: Any, other: Any) -> bool:
    if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)):
        return False
    if one.dtype.kind not in "fc" or other.dtype.kind not in "fc":
        return bool(np.array_equal(one, other))
    return bool(np.array_equal(one, other, equal_nan=True))
