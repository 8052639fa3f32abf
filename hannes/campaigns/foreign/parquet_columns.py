"""Columns of Parquet files, and of LeRobot data sets (version 3), which are folders of them.

Vectors such as `observation.state` are taken apart: `observation.state/3`, or by the names that
the data set gives them, `observation.state/elbow_flex.pos`.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import MOST_VALUES, Arrays
from hannes.core.errors import BadInput
from hannes.core.io.optional import library

FloatArray = NDArray[np.float64]

INFO = Path("meta") / "info.json"  # of a LeRobot data set


def open_parquet(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read one .parquet file, or the folder of a LeRobot data set."""
    files = _files(path)
    names = _names(path)
    tables = [_table(file) for file in files]
    found: dict[str, list[FloatArray]] = {}
    for table in tables:
        for name, values in _columns(table, names).items():
            found.setdefault(name, []).append(values)
    joined = {name: np.concatenate(parts) for name, parts in found.items()}
    if not joined:
        raise BadInput(f"{path}: holds no columns of numbers")
    return Arrays(path, joined, joined.__getitem__, missing)


def is_lerobot(path: Path) -> bool:
    """Whether a folder is a LeRobot data set."""
    return (path / INFO).is_file()


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [path]
    found = sorted((path / "data").rglob("*.parquet"))
    if not found:
        raise BadInput(f"{path}: no .parquet file below its folder data")
    return found


def _names(path: Path) -> dict[str, list[str]]:
    """Names of the parts of vectors, as the data set's info gives them."""
    if not path.is_dir():
        return {}
    try:
        features = json.loads((path / INFO).read_text(encoding="utf-8"))["features"]
    except (OSError, ValueError, KeyError, RecursionError):
        raise BadInput(f"{path / INFO}: cannot be read; expected a LeRobot data set") from None
    named = {}
    for name, each in features.items() if isinstance(features, dict) else ():
        parts = each.get("names") if isinstance(each, dict) else None
        if isinstance(parts, dict):  # {"motors": [...]}
            parts = next(iter(parts.values()), None)
        if isinstance(parts, list) and all(isinstance(part, str) for part in parts):
            named[name] = parts
    return named


def _table(file: Path) -> Any:
    parquet = library("pyarrow.parquet", "formats")
    try:
        head = parquet.ParquetFile(file)
        if head.metadata.num_rows * head.metadata.num_columns > MOST_VALUES:
            raise BadInput(f"{file}: {head.metadata.num_rows} rows are too many; cut it")
        return head.read()
    except BadInput:
        raise
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{file}: cannot be read as Parquet ({reason})") from None


def _columns(table: Any, names: dict[str, list[str]]) -> dict[str, FloatArray]:
    found: dict[str, FloatArray] = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        found |= _column(name, column, names.get(name, []))
    return found


def _column(name: str, column: Any, parts: list[str]) -> dict[str, FloatArray]:
    """A column of numbers as it is, one of equally long lists by its parts."""
    types = library("pyarrow.types", "formats")
    kind = column.type
    if types.is_timestamp(kind):
        stamps = column.to_numpy().astype("datetime64[ns]").astype(np.int64)
        return {name: (stamps - stamps[0]) * 1e-9}
    if types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind):
        return {name: np.asarray(column.to_numpy(zero_copy_only=False), np.float64)}
    if not (types.is_list(kind) or types.is_fixed_size_list(kind) or types.is_large_list(kind)):
        return {}
    if types.is_nested(kind.value_type) or not len(column):
        return {}
    rows = [row if row is not None else [] for row in column.to_pylist()]
    width = max(map(len, rows))
    if any(isinstance(value, str | bytes | dict) for value in rows[0]):
        return {}
    matrix = np.full((len(rows), width), np.nan)
    for k, row in enumerate(rows):
        matrix[k, : len(row)] = row
    labels = parts if len(parts) == width else [str(k + 1) for k in range(width)]
    return {f"{name}/{label}": matrix[:, k] for k, label in enumerate(labels)}
