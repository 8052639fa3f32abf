"""Columns of binary files: datasets of an HDF5 file, variables of a MATLAB file."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.mapping import Column
from hannes.core.errors import BadInput, nearest
from hannes.core.recording.hdf5 import OWN_FILTERS

FloatArray = NDArray[np.float64]

MOST_VALUES = 50_000_000  # of one dataset, 400 MB


class Arrays:
    """Numeric arrays by path (`log/motor/current`); NaN stands for a value that is missing."""

    def __init__(
        self, path: Path, names: Iterable[str], read: Callable[[str], Any], missing: tuple[str, ...]
    ) -> None:
        self.path, self.names, self.read, self.missing = path, tuple(names), read, missing

    def place(self, row: int) -> str:
        """File and sample of a row, as messages show them."""
        return f"{self.path}, sample {row + 1}"

    def numbers(self, column: Column) -> FloatArray:
        """Values of a dataset or variable, shape (n,); BadInput where it is no row of numbers."""
        name = str(column.name).strip("/")
        if name not in self.names:
            name = name.replace(".", "/").strip("/")
        if not isinstance(column.name, str) or name not in self.names:
            shown = ", ".join(self.names)
            hint = nearest(name, self.names)
            raise BadInput(f'{self.path}: holds no "{column.name}"{hint} (it has {shown:.300})')
        values = self._row(np.asarray(self.read(name)), column)
        for text in self.missing:
            values[values == _as_number(text)] = np.nan
        if np.isinf(values).any():
            row = int(np.isinf(values).argmax())
            raise BadInput(f'{self.place(row)}: "{name}" is not finite; list inf under missing')
        return values

    def stamps(self, column: Column) -> FloatArray:
        """Binary files hold numbers."""
        raise BadInput(f'{self.path}: format = "iso" is for text files')

    def _row(self, values: NDArray[Any], column: Column) -> FloatArray:
        """The only axis, or the column `index`; a copy."""
        where = f'{self.path}: "{column.name}"'
        if values.dtype.kind not in "fiub":
            raise BadInput(f"{where} holds no real numbers")
        values = np.squeeze(values)
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

    names: list[str] = []

    def keep(name: str, item: Any) -> None:
        if isinstance(name, str) and isinstance(item, h5py.Dataset) and _harmless(item):
            names.append(name)

    def look(file: Any) -> None:
        file.visititems(keep)  # visits hard links alone

    _in_hdf5(path, look)
    return Arrays(path, names, lambda name: _in_hdf5(path, lambda file: file[name][()]), missing)


def _in_hdf5(path: Path, use: Callable[[Any], Any]) -> Any:
    import h5py

    _require(path)
    try:
        with h5py.File(path, "r") as file:
            return use(file)
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as HDF5 ({reason})") from None


def _harmless(dataset: Any) -> bool:
    made = dataset.id.get_create_plist()
    filters = {made.get_filter(place)[0] for place in range(made.get_nfilters())}
    inside = not dataset.is_virtual and not dataset.external and filters <= OWN_FILTERS
    return inside and dataset.dtype.kind in "fiub" and 0 < dataset.size <= MOST_VALUES


def open_mat(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read the numeric variables of a MATLAB file, those inside structures by their path."""
    from scipy.io import loadmat

    _require(path)
    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:  # version 7.3 is HDF5
        return open_hdf5(path, missing)
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: is no MATLAB file ({reason})") from None
    variables = dict(_variables(content))
    return Arrays(path, variables, variables.__getitem__, missing)


def _variables(content: dict[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for name, value in content.items():
        if isinstance(value, dict):
            found += _variables(value, f"{prefix}{name}/")
        elif not name.startswith("__") and np.asarray(value).dtype.kind in "fiub":
            found.append((f"{prefix}{name}", value))
    return found


def _require(path: Path) -> None:
    if not path.is_file():
        near = nearest(path.name, [each.name for each in path.parent.glob("*")])
        raise BadInput(f"{path}: there is no such file{near}")


def _as_number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan
