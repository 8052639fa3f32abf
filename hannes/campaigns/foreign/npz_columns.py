"""Columns of numpy's own files: arrays by name (.npz), or one array (.npy). Nothing is executed."""

from pathlib import Path

import numpy as np

from hannes.campaigns.foreign.binary_columns import MOST_VALUES, Arrays
from hannes.core.errors import BadInput

ALONE = "data"  # name of the one array of a .npy file


def open_npz(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read .npz or .npy; fields of structured arrays by `array/field`."""
    if not path.is_file():
        raise BadInput(f"{path}: there is no such file")
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
            return _of_archive(path, content, missing)
    except (TypeError, AttributeError):
        return _of_array(path, missing)
    except BadInput:
        raise
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as numpy arrays ({reason})") from None


def _of_archive(path: Path, content: "np.lib.npyio.NpzFile", missing: tuple[str, ...]) -> Arrays:
    import zipfile

    with zipfile.ZipFile(path) as archive:
        sizes = {each.filename.removesuffix(".npy"): each.file_size for each in archive.infolist()}
    found: dict[str, np.ndarray] = {}
    for name in content.files:
        if sizes.get(name, 0) > 8 * MOST_VALUES:
            raise BadInput(f'{path}: "{name}" has {sizes[name]} bytes; expected at most 400 MB')
        try:
            array = content[name]
        except ValueError:  # objects, which only code could read
            continue
        found |= _fields(name, array)
    return Arrays(path, found, found.__getitem__, missing)


def _of_array(path: Path, missing: tuple[str, ...]) -> Arrays:
    try:
        found = _fields(ALONE, np.load(path, allow_pickle=False))
    except Exception as error:  # as above
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as a numpy array ({reason})") from None
    return Arrays(path, found, found.__getitem__, missing)


def _fields(name: str, array: np.ndarray) -> dict[str, np.ndarray]:
    if array.dtype.names:
        return {f"{name}/{field}": array[field] for field in array.dtype.names}
    return {name: array} if array.dtype.kind in "fiub" and array.size else {}
