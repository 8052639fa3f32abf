"""To how much an MCAP log unpacks: its library takes whatever comes.

A record is a byte that says what it is, its length [bytes] u64, and its content. That of a chunk is
start, end, size unpacked (u64 each), CRC u32, the name of the compression and the packed records,
each with its length before it (u32, u64).
"""

import io
import struct
from pathlib import Path
from typing import BinaryIO

from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK, opened
from hannes.core.io.limits import BYTES, MIB
from hannes.core.io.optional import library

MAGIC = 8
RECORD, CHUNK = struct.Struct("<BQ"), struct.Struct("<QQQII")
IS_CHUNK = 6


def require_unpackable(path: Path) -> None:
    """Raise BadInput where a log would unpack to more than BYTES."""
    left = BYTES
    with opened(path, "a log of messages") as file:
        end = MAGIC
        file.seek(end)
        while len(head := file.read(RECORD.size)) == RECORD.size:
            kind, length = RECORD.unpack(head)
            if length > BYTES:
                return  # damaged: its library says so
            end += RECORD.size + length
            if kind == IS_CHUNK:
                left -= _unpacked(file, length, left)
            if left < 0:
                raise BadInput(f"{path}: unpacks to more than {BYTES // MIB} MiB; cut it")
            file.seek(end)


def _unpacked(file: BinaryIO, length: int, most: int) -> int:
    """Bytes of a chunk's records, counted up to just above `most`."""
    head = file.read(CHUNK.size)
    if len(head) < CHUNK.size:
        return 0
    name = file.read(min(CHUNK.unpack(head)[4], 64))
    file.read(8)
    data = file.read(min(length, BYTES))
    if name == b"zstd":
        stream = library("zstandard", "formats").ZstdDecompressor().stream_reader(io.BytesIO(data))
    elif name == b"lz4":
        stream = library("lz4.frame", "formats").LZ4FrameFile(io.BytesIO(data))
    else:
        return len(data)
    count = 0
    try:
        while count <= most and (block := stream.read(BLOCK)):
            count += len(block)
    except Exception:  # a damaged chunk: the log's library says so
        return count
    return count
