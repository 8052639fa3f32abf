"""Columns of Parquet files, and of LeRobot data sets (version 3), which are folders of them.

Vectors such as `observation.state` are taken apart: `observation.state/3`, or by the names that
the data set gives them, `observation.state/elbow_flex.pos`.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.foreign.binary_columns import Arrays, require_file
from hannes.campaigns.foreign.parquet_size import require_unpackable
from hannes.campaigns.foreign.text_codes import TextCodes
from hannes.core.errors import BadInput
from hannes.core.io.bounded import read_bytes
from hannes.core.io.json_text import parsed
from hannes.core.io.limits import BYTES, COLUMNS, MIB, VALUES, table_fits
from hannes.core.io.optional import library

FloatArray = NDArray[np.float64]

BATCH = 65_536  # rows
MOST_INFO = 16 * MIB
INFO = Path("meta") / "info.json"  # of a LeRobot data set


def open_parquet(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read one .parquet file, or the folder of a LeRobot data set."""
    names = _names(path)
    found: dict[str, list[NDArray[Any]]] = {}
    codes: dict[str, TextCodes] = {}
    count = 0
    for batch in (each for file in _files(path) for each in _batches(file)):
        for name, values in _columns(batch, names, str(path)).items():
            found.setdefault(name, []).append(values)
            count += values.size
        count += _add_texts(batch, codes)
        if count > VALUES or len(found) > COLUMNS:
            raise BadInput(f"{path}: more than {VALUES} numbers or {COLUMNS} columns; cut it")
    joined = {name: _seconds(np.concatenate(parts)) for name, parts in found.items()}
    if not joined:
        raise BadInput(f"{path}: holds no columns of numbers")
    texts = {name: each for name, code in codes.items() if (each := code.texts) is not None}
    return Arrays(path, joined, joined.__getitem__, missing, texts=texts)


def is_lerobot(path: Path) -> bool:
    """Whether a folder is a LeRobot data set."""
    return (path / INFO).is_file()


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        require_file(path)
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
        features = parsed(read_bytes(path / INFO, most=MOST_INFO))["features"]
    except (TypeError, ValueError, KeyError):
        raise BadInput(f"{path / INFO}: cannot be read; expected a LeRobot data set") from None
    named = {}
    for name, each in features.items() if isinstance(features, dict) else ():
        parts = each.get("names") if isinstance(each, dict) else None
        if isinstance(parts, dict):  # {"motors": [...]}
            parts = next(iter(parts.values()), None)
        if isinstance(parts, list) and all(isinstance(part, str) for part in parts):
            named[name] = parts
    return named


def _batches(file: Path) -> Iterator[Any]:
    """Rows of a file in parts; BadInput where it is damaged or unpacks to too much."""
    parquet = library("pyarrow.parquet", "formats")
    require_unpackable(file)
    try:
        with parquet.ParquetFile(file) as head:
            _require_small(file, head.metadata)
            yield from head.iter_batches(BATCH, use_threads=False)
    except BadInput:
        raise
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{file}: cannot be read as Parquet ({reason})") from None


def _require_small(file: Path, head: Any) -> None:
    if head.num_rows * head.num_columns > VALUES:
        raise BadInput(f"{file}: {head.num_rows} rows are too many; cut it")
    # The sizes of single columns are not asked for: of a damaged file that ends Python.
    size = sum(max(head.row_group(k).total_byte_size, 0) for k in range(head.num_row_groups))
    if size > BYTES:
        raise BadInput(f"{file}: unpacks to {size // MIB} MiB, more than {BYTES // MIB}; cut it")


def _columns(batch: Any, names: dict[str, list[str]], where: str) -> dict[str, NDArray[Any]]:
    found: dict[str, NDArray[Any]] = {}
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        found |= _column(name, column, names.get(name, []), where)
    return found


def _add_texts(batch: Any, codes: dict[str, TextCodes]) -> int:
    """Add the columns of texts of a batch; return how many cells they have."""
    types = library("pyarrow.types", "formats")
    count = 0
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        packed = types.is_dictionary(column.type)
        kind = column.type.value_type if packed else column.type
        if not (types.is_string(kind) or types.is_large_string(kind)):
            continue
        encoded = column if packed else column.dictionary_encode()
        indices = np.nan_to_num(_numbers(encoded.indices), nan=-1.0).astype(np.intp)
        codes.setdefault(name, TextCodes()).extend(encoded.dictionary.to_pylist(), indices)
        count += indices.size
    return count


def _column(name: str, column: Any, parts: list[str], where: str) -> dict[str, NDArray[Any]]:
    """A column of numbers as it is, one of equally long lists by its parts."""
    types = library("pyarrow.types", "formats")
    kind = column.type
    if types.is_timestamp(kind):
        stamps = column.to_numpy(zero_copy_only=False).astype("datetime64[ns]")
        return {name: stamps}
    if types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind):
        return {name: _numbers(column)}
    if not (types.is_list(kind) or types.is_fixed_size_list(kind) or types.is_large_list(kind)):
        return {}
    inner = kind.value_type
    if not (types.is_integer(inner) or types.is_floating(inner) or types.is_boolean(inner)):
        return {}
    matrix = _matrix(column, where)
    width = matrix.shape[1]
    labels = parts if len(parts) == width else [str(k + 1) for k in range(width)]
    return {f"{name}/{label}": matrix[:, k] for k, label in enumerate(labels)}


def _seconds(values: NDArray[Any]) -> FloatArray:
    """Time stamps as seconds since the first one, NaN where one is missing; numbers as they are."""
    if values.dtype.kind != "M":
        return values
    start = values[~np.isnat(values)][:1]
    return (values - (start[0] if start.size else values[0])) / np.timedelta64(1, "s")


def _numbers(column: Any) -> FloatArray:
    return np.array(column.to_numpy(zero_copy_only=False), np.float64)


def _matrix(column: Any, where: str) -> FloatArray:
    """Lists as rows, short ones filled with NaN."""
    lengths = np.nan_to_num(_numbers(column.value_lengths())).astype(np.intp)
    values, width = _numbers(column.flatten()), int(lengths.max(initial=0))
    if width > COLUMNS or not table_fits(lengths.size, width, 8 * values.size):
        raise BadInput(f"{where}: lists of up to {width} values are too long for columns")
    matrix = np.full((lengths.size, width), np.nan)
    matrix[np.arange(width) < lengths[:, np.newaxis]] = values
    return matrix
