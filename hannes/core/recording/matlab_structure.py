"""Whether a MATLAB file (version 5) is built as its description says, before scipy reads it.

scipy takes kinds of elements and numbers of dimensions as they come: a damaged one crashes Python.
A file is elements, each with a tag of its kind and its size; a matrix is a row of elements, the
first two of them its flags and its dimensions. Packed elements are unpacked no further than BYTES.
"""

import struct
import zlib
from typing import BinaryIO

from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK
from hannes.core.io.limits import BYTES, MIB

HEAD, TAG = 128, 8
NUMBERS, UNICODE = {1, 2, 3, 4, 5, 6, 7, 9, 12, 13}, {16, 17, 18}
INT8, INT32, UINT32, MATRIX, PACKED = 1, 5, 6, 14, 15
KINDS = NUMBERS | UNICODE | {MATRIX, PACKED}
CELL, STRUCTURE, OBJECT, CHARACTERS, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17  # classes
COMPLEX = 0x800  # flag
MOST_DIMENSIONS, DEEPEST = 32, 50


def check_structure(file: BinaryIO) -> None:
    """Raise BadInput where an element cannot be what it says; files of other versions pass."""
    head = file.read(HEAD)
    order = {b"IM": "<", b"MI": ">"}.get(head[126:128])
    if order is None or 0 in head[:4] or head[124:126] not in (b"\0\1", b"\1\0"):
        return
    left = BYTES
    while len(tag := file.read(TAG)) == TAG:
        kind, size = struct.unpack(f"{order}II", tag)
        if kind not in (MATRIX, PACKED) or size > BYTES:
            raise BadInput(f"{file.name}: an element of kind {kind} with {size} bytes; damaged")
        if kind == PACKED:
            data = _unpacked(file, size, left)
            left -= len(data)
            _check(memoryview(data), order, 0, file.name)
        else:
            _check(memoryview(tag + file.read(size)), order, 0, file.name)


def _unpacked(file: BinaryIO, size: int, most: int) -> bytearray:
    packed, found = zlib.decompressobj(), bytearray()
    while size > 0 and (data := file.read(min(size, BLOCK))):
        size -= len(data)
        while data:
            found += packed.decompress(data, BLOCK)
            data = packed.unconsumed_tail
            if len(found) > most:
                raise BadInput(f"{file.name}: unpacks to more than {BYTES // MIB} MiB")
    return found


def _check(data: memoryview, order: str, depth: int, name: str) -> None:
    """Check a row of elements; those of a matrix in turn."""
    at, flags = 0, 0
    kinds: list[int] = []
    while at + TAG <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        start, next_at, most = at + TAG, at + TAG + -(-size // 8) * 8, len(data)
        if kind >> 16:  # a small element: both in four bytes, its data in the other four
            kind, size, start, next_at, most = kind & 0xFFFF, kind >> 16, at + 4, at + TAG, at + TAG
        wrong = kind not in KINDS or start + size > most
        if depth and not kinds and not wrong and (kind, size) == (UINT32, 8):
            flags = struct.unpack_from(f"{order}I", data, start)[0]
        if wrong or depth > DEEPEST or (len(kinds) == 1 and size > 4 * MOST_DIMENSIONS):
            raise BadInput(f"{name}: an element of kind {kind} with {size} bytes; damaged")
        if kind == MATRIX and size:
            _check(data[start : start + size], order, depth + 1, name)
        kinds.append(kind)
        at = next_at
    if depth and not _fits(kinds, flags & 0xFF, bool(flags & COMPLEX)):
        raise BadInput(f"{name}: a matrix without the parts of its class {flags & 0xFF}; damaged")


def _fits(kinds: list[int], of_class: int, complex_: bool) -> bool:
    """Whether a matrix has the parts that its class needs, after flags, dimensions and name."""
    if of_class == OPAQUE:
        return True
    if kinds[:2] != [UINT32, INT32] or len(kinds) < 3:
        return False
    rest = kinds[3:]
    if of_class in (CELL, FUNCTION):
        return all(kind == MATRIX for kind in rest)
    if of_class in (STRUCTURE, OBJECT):
        names = rest[1:] if of_class == OBJECT else rest
        return names[:2] == [INT32, INT8] and all(kind == MATRIX for kind in names[2:])
    if of_class == CHARACTERS:
        return len(rest) == 1 and rest[0] in NUMBERS | UNICODE
    wanted = 3 if of_class == SPARSE else 1
    return of_class <= FUNCTION and len(rest) == wanted + complex_ and NUMBERS.issuperset(rest)
