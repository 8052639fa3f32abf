"""Columns of numpy's own files: arrays by name (.npz), or one array (.npy). Nothing is executed."""

import math
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from hannes.campaigns.foreign.binary_columns import Arrays, require_file
from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK, opened
from hannes.core.io.limits import COLUMNS, VALUES

ALONE = "data"  # name of the one array of a .npy file
ZIP = b"PK"


def open_npz(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read .npz or .npy; fields of structured arrays by `array/field`."""
    require_file(path)
    found: dict[str, np.ndarray] = {}
    objects: list[str] = []
    try:
        with opened(path, "numpy arrays") as file:
            for name, array in _arrays(file):
                if array is None:
                    objects.append(name)
                    continue
                found |= _fields(name, array)
                if sum(each.size for each in found.values()) > VALUES or len(found) > COLUMNS:
                    raise BadInput(f"{path}: holds more than {VALUES} numbers or {COLUMNS} arrays")
    except BadInput:
        raise
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as numpy arrays ({reason})") from None
    if objects and not found:
        raise BadInput(
            f"{path}: {', '.join(objects)[:200]}: holds Python objects, which could run code; save "
            "arrays of numbers, such as run1_time, run1_position"
        )
    return Arrays(path, found, found.__getitem__, missing)


def _arrays(file: IO[bytes]) -> Iterator[tuple[str, np.ndarray | None]]:
    """Arrays by name, None for those of objects."""
    packed = file.read(len(ZIP)) == ZIP
    file.seek(0)
    if not packed:
        yield ALONE, _array(file)
        return
    with zipfile.ZipFile(file) as archive:
        for entry in archive.infolist():
            with archive.open(entry) as stream:
                array = _array(stream)
            yield entry.filename.removesuffix(".npy"), array


def _array(stream: IO[bytes]) -> np.ndarray | None:
    """One array, None where it holds objects: those only code could read.

    Its bytes are read as far as they come; the size that its head states is an upper bound.
    """
    version = npy.read_magic(stream)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, fortran, kind = read(stream)
    if kind.hasobject:
        return None
    size = math.prod(shape) * kind.itemsize
    if not 0 <= size <= 8 * VALUES:
        raise ValueError(f"an array of {shape}, more than {VALUES} numbers: cut it into parts")
    array = np.frombuffer(_read(stream, size), kind)
    return array.reshape(shape[::-1]).T if fortran else array.reshape(shape)


def _read(stream: IO[bytes], size: int) -> bytearray:
    data = bytearray()
    while len(data) < size:
        block = stream.read(min(BLOCK, size - len(data)))
        if not block:
            raise ValueError(f"ends after {len(data)} of {size} bytes")
        data += block
    return data


def _fields(name: str, array: Any) -> dict[str, np.ndarray]:
    if array.dtype.names:
        return {f"{name}/{field}": array[field] for field in array.dtype.names}
    return {name: array} if array.dtype.kind in "fiub" and array.size else {}
