"""Arrays of an HDF5 file that may come from anywhere: inside it, plainly stored, within limits.

Links out of the file, external and virtual storage and filters of plugins are refused. HDF5 itself
unpacks a block as far as it goes, whatever the file says of its size: blocks that could become
large are unpacked here first, up to their size and no further.
"""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import BadInput
from hannes.core.io.bounded import require_regular
from hannes.core.io.limits import BLOCKS, UNPACKING, VALUES

DEFLATE, SHUFFLE, FLETCHER = 1, 2, 3  # filters that are built into the library
HARMLESS = 16 << 20  # bytes to which a block may grow unseen


@contextmanager
def hdf5_file(path: str | Path, what: str) -> Iterator[Any]:
    """Yield an h5py.File to be read; BadInput where it is damaged, another, or refused within."""
    import h5py

    require_regular(path, what)
    try:
        with h5py.File(path, "r") as file:
            yield file
    except BadInput as error:
        message = str(error)
        raise BadInput(message if message.startswith(str(path)) else f"{path}: {message}") from None
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        raise BadInput(f"{path}: cannot be read as {what}, {_why(error)}") from error


def _why(error: Exception) -> str:
    """What is wrong and what to do: the library's own words are of its inside."""
    if isinstance(error, PermissionError):
        return "you may not read it: ask its owner"
    if "truncated" in str(error):
        return "it is cut off: copy it again, or make it anew"
    return "it is damaged or of another kind: copy it again, or make it anew"


def member(group: Any, place: str, kind: type) -> Any:
    """A group or dataset at `place`, to which hard links alone lead; BadInput otherwise."""
    import h5py

    *above, last = place.split("/")
    for name in above:
        group = member(group, name, h5py.Group)
    if not isinstance(group.get(last, getlink=True), h5py.HardLink):
        raise BadInput(f'expected "{place}" inside the file, found no such member or a link')
    if group.get(last, getclass=True) is not kind:
        raise BadInput(f'expected "{place}" to be a {kind.__name__.lower()}')
    return group[last]


def require_plain(dataset: Any, most: int = VALUES) -> Any:
    """Return a dataset whose numbers can be read; BadInput where that could reach too far.

    It has at most `most` elements, and lies in this file, plainly or deflated.
    """
    name = dataset.name
    if dataset.shape is None:
        raise BadInput(f"{name}: is empty")
    stored = dataset.id.get_storage_size()
    if dataset.size * dataset.dtype.itemsize > UNPACKING * max(stored, 1):
        raise BadInput(f"{name}: claims far more rows than the file holds")
    if dataset.size > most:
        raise BadInput(f"{name}: holds {dataset.size} values, more than {most}; cut it into parts")
    if not _inside(dataset):
        raise BadInput(f"{name}: expected plain or gzip storage inside this file")
    if dataset.chunks:
        _check_blocks(dataset)
    return dataset


def _inside(dataset: Any) -> bool:
    made = dataset.id.get_create_plist()
    filters = [made.get_filter(place)[0] for place in range(made.get_nfilters())]
    usual = [each for each in (SHUFFLE, DEFLATE, FLETCHER) if each in filters]
    return not dataset.is_virtual and not dataset.external and filters == usual


def _check_blocks(dataset: Any) -> None:
    size = int(np.prod(dataset.chunks, dtype=object)) * dataset.dtype.itemsize
    if size > 8 * VALUES:
        raise BadInput(f"{dataset.name}: blocks of {dataset.chunks} are too large to read")
    found: list[Any] = []

    def keep(block: Any) -> bool | None:
        found.append(block)
        return True if len(found) > BLOCKS else None

    dataset.id.chunk_iter(keep)
    if len(found) > BLOCKS:
        raise BadInput(f"{dataset.name}: is stored in more than {BLOCKS} blocks")
    length = dataset.file.id.get_filesize()
    if sum(each.size for each in found) > length:
        raise BadInput(f"{dataset.name}: claims larger blocks than the file")
    made = dataset.id.get_create_plist()
    if DEFLATE in [made.get_filter(place)[0] for place in range(made.get_nfilters())]:
        for each in found:
            if UNPACKING * each.size > size + HARMLESS:
                _unpack(dataset, each.chunk_offset, size)


def _unpack(dataset: Any, offset: tuple[int, ...], size: int) -> None:
    """Unpack one block as far as it may go; BadInput where more would come."""
    _, data = dataset.id.read_direct_chunk(offset)
    try:
        whole = zlib.decompressobj().decompress(data, size + 1)
    except zlib.error:
        return  # not packed, or damaged: HDF5 says so
    if len(whole) > size:
        raise BadInput(f"{dataset.name}: a block unpacks to more than its {size} bytes")
