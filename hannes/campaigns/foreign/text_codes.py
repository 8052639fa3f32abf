"""Columns of texts as numbers of few different ones, such as the names of signals."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hannes.core.io.limits import COLUMNS


@dataclass(frozen=True)
class Texts:
    """A column of texts: the different ones, and of each row (n,) the place of its own, or -1."""

    names: tuple[str, ...]
    codes: NDArray[np.intp]


class TextCodes:
    """Texts of a column as they come; with more than COLUMNS different ones they are no names."""

    def __init__(self) -> None:
        self._places: dict[str, int] = {}
        self._rows = array("q")

    def extend(self, texts: Sequence[str | None], indices: NDArray[np.intp]) -> None:
        """Add rows, of which `indices` say the place in `texts`, below zero for none."""
        if len(self._places) <= COLUMNS:
            places = np.array([*(self._place(text) for text in texts), -1], np.int64)
            self._rows.frombytes(places[np.maximum(indices, -1)].tobytes())

    def _place(self, text: str | None) -> int:
        return -1 if text is None else self._places.setdefault(text, len(self._places))

    @property
    def texts(self) -> Texts | None:
        """The column, None where its texts are no names."""
        if not 0 < len(self._places) <= COLUMNS:
            return None
        return Texts(tuple(self._places), np.frombuffer(self._rows, np.int64).astype(np.intp))
