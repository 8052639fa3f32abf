"""Columns of binary files by path; datasets of an HDF5 file, MATLAB's version 7.3 included."""

import itertools
import os
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import Column
from hannes.campaigns.foreign.text_codes import Texts
from hannes.core.errors import BadInput, nearest
from hannes.core.io.bounded import require_regular
from hannes.core.io.inputs import note
from hannes.core.io.limits import COLUMNS
from hannes.core.recording.hdf5_storage import hdf5_file, require_plain

FloatArray = NDArray[np.float64]

MOST_CELLS, DEEPEST = 1000, 4  # of a dataset of references


class Arrays:
    """Numeric arrays by path (`log/motor/current`); NaN stands for a value that is missing.

    texts: columns of names, such as those of signals in a long table;
    captions: what the file says of an array apart from its path, such as a label with a unit;
    units: of arrays by path, as the file spells them.
    """

    def __init__(
        self,
        path: Path,
        names: Iterable[str],
        read: Callable[[str], Any],
        missing: tuple[str, ...],
        captions: Mapping[str, str] | None = None,
        texts: Mapping[str, Texts] | None = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        self.path, self.names, self.read, self.missing = path, tuple(names), read, missing
        self.captions, self._texts = captions or {}, texts or {}
        self.units = units or {}
        self.text_names = tuple(self._texts)

    def place(self, row: int) -> str:
        """File and sample of a row, as messages show them."""
        return f"{self.path}, sample {row + 1}"

    def numbers(self, column: Column) -> FloatArray:
        """Values of a dataset or variable, shape (n,); BadInput where it is no row of numbers."""
        name, index = self._found(column)
        values = self._row(np.asarray(self.read(name)), Column(column.name, index))
        return self._finite(name, values)

    def table(self, column: Column) -> FloatArray:
        """Values with their one or two axes; of several channels those at `index` as one."""
        name, index = self._found(column)
        values = np.squeeze(np.asarray(self.read(name)))
        if index or values.ndim != 2:
            return self.numbers(column)
        return self._finite(name, self._real(values, name).astype(np.float64))

    def _finite(self, name: str, values: FloatArray) -> FloatArray:
        for text in self.missing:
            values[values == _as_number(text)] = np.nan
        if np.isinf(values).any():
            row = int(np.isinf(values).argmax())
            raise BadInput(f'{self.place(row)}: "{name}" is not finite; list inf under missing')
        return values

    def stamps(self, column: Column, pattern: str = "") -> FloatArray:
        """Binary files hold numbers."""
        raise BadInput(f"{self.path}: time.format is for text; the times here are numbers")

    def labels(self, column: Column) -> FloatArray:
        """The numbers themselves, or of texts their numbers."""
        if column.name in self._texts:
            return self._texts[str(column.name)].codes.astype(np.float64)
        return self.numbers(column)

    def texts(self, column: Column) -> Texts:
        """A column of names; BadInput where there is none."""
        if column.name not in self._texts:
            shown = ", ".join(self._texts)
            raise BadInput(f'{self.path}: no column of texts "{column.name}" (it has {shown:.300})')
        return self._texts[str(column.name)]

    def breaks(self, kind: str) -> NDArray[np.intp]:
        """Binary files have no lines."""
        raise BadInput(f'{self.path}: split_at = "{kind}" is for text; use "restart"')

    def _found(self, column: Column) -> tuple[str, int]:
        """Path of a column, and the index that is left once one led into a list or cell."""
        if isinstance(column.name, str):
            for name in (column.name.strip("/"), as_path(column.name)):
                if name in self.names:
                    return name, column.index
            parts = as_path(column.name).split("/")
            for k in range(len(parts), 0, -1):
                name = "/".join([*parts[:k], str(column.index), *parts[k:]])
                if column.index and name in self.names:
                    return name, 0
        shown, hint = ", ".join(self.names), nearest(str(column.name), self.names)
        raise BadInput(f'{self.path}: holds no "{column.name}"{hint} (it has {shown:.300})')

    def _real(self, values: NDArray[Any], name: str | int) -> NDArray[Any]:
        if values.dtype.kind not in "fiub":
            raise BadInput(f'{self.path}: "{name}" holds no real numbers')
        return values

    def _row(self, values: NDArray[Any], column: Column) -> FloatArray:
        """The only axis, or the column `index`; a copy."""
        where = f'{self.path}: "{column.name}"'
        values = np.squeeze(self._real(values, column.name))
        if values.ndim == 2 and column.index:
            values = values if values.shape[0] >= values.shape[1] else values.T
            if column.index > values.shape[1]:
                raise BadInput(f"{where} has {values.shape[1]} columns, no number {column.index}")
            values = values[:, column.index - 1]
        elif values.ndim != 1 or column.index:
            advice = "leave index out" if values.ndim == 1 else "say which column with index"
            raise BadInput(f"{where} has the shape {values.shape}: {advice}")
        return values.astype(np.float64)


def open_hdf5(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Find the datasets of an HDF5 file; links to the outside are not followed."""
    import h5py

    places: dict[str, str] = {}

    def keep(name: str, item: Any) -> None:
        if isinstance(name, str) and isinstance(item, h5py.Dataset):
            _note(name, item, places)

    def look(file: Any) -> None:
        file.visititems(keep)  # visits hard links alone

    _in_hdf5(path, look)
    names = [name for name in places if not name.startswith("#refs#")]

    def read(name: str) -> Any:
        return _in_hdf5(path, lambda file: require_plain(file[places[name]])[()])

    return Arrays(path, names, read, missing)


def _in_hdf5(path: Path, use: Callable[[Any], Any]) -> Any:
    require_file(path)
    with hdf5_file(path, "HDF5") as file:
        return use(file)


def _note(name: str, dataset: Any, places: dict[str, str], depth: int = 0) -> None:
    """Note a dataset of numbers by its name; of cells (references, MATLAB 7.3) each by number."""
    import h5py

    if len(places) > COLUMNS:
        raise BadInput(f"holds more than {COLUMNS} datasets")
    if h5py.check_ref_dtype(dataset.dtype) is not h5py.Reference:
        if dataset.dtype.kind in "fiub" and dataset.size:
            places[name] = dataset.name
        return
    if not dataset.size or dataset.size > MOST_CELLS or depth > DEEPEST:
        return
    for number, reference in enumerate(require_plain(dataset)[()].ravel(), start=1):
        target = dataset.file[reference] if reference else None
        for part, each in _inside(target).items():
            _note(f"{name}/{number}/{part}".rstrip("/"), each, places, depth + 1)


def _inside(target: Any) -> dict[str, Any]:
    """Datasets to which a reference leads: itself, or those below a group by hard links."""
    import h5py

    if isinstance(target, h5py.Dataset):
        return {"": target}
    found: dict[str, Any] = {}

    def keep(name: str, item: Any) -> bool | None:
        if isinstance(name, str) and isinstance(item, h5py.Dataset):
            found[name] = item
        return True if len(found) > COLUMNS else None

    if isinstance(target, h5py.Group):
        target.visititems(keep)  # visits hard links alone, and each object once
    return found


def require_file(path: Path) -> None:
    """Raise BadInput where there is no regular file, with the nearest name beside it."""
    note(path)
    if not os.path.lexists(path) and path.parent.is_dir():
        near = nearest(path.name, itertools.islice((x.name for x in path.parent.glob("*")), 1000))
        raise BadInput(f"{path}: there is no such file{near}")
    require_regular(path)


def as_path(name: str) -> str:
    """A path as MATLAB or Python writes it, `log.signals(1).values`, with slashes."""
    return re.sub(r"/+", "/", re.sub(r"[.(){}\[\]]", "/", name)).strip("/")


def _as_number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan
