"""To how much a ROS log unpacks, and what its SQLite holds: its library takes whatever comes.

ROS 1 bags are records: a head (its length u32, fields `name=value`, each with its length before
it), then data (its length u32). That of a chunk (op 5) is packed as the field `compression` says.
rosbag2 is a folder of MCAP or SQLite files, each packed as a whole, or message by message (zstd).
"""

import bz2
import io
import sqlite3
import struct
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, BinaryIO

from hannes.campaigns.foreign import mcap_size
from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK, opened, require_regular
from hannes.core.io.limits import BYTES, MIB
from hannes.core.io.optional import library

LENGTH = struct.Struct("<I")
LONGEST_HEAD = 64 * MIB  # of a record: definitions of messages
MOST_METADATA = MIB  # bytes of metadata.yaml
MOST_FILES = 1000
IS_CHUNK = b"\x05"
ENDINGS = (".mcap", ".db3", ".zstd")


def require_unpackable(path: Path) -> None:
    """Raise BadInput where a ROS log, a file or a folder, would unpack to more than BYTES."""
    if not path.is_dir():
        return _require_file(path)
    require_regular(path / "metadata.yaml", "metadata of a rosbag2", MOST_METADATA)
    files = [each for each in path.iterdir() if each.suffix.lower() in ENDINGS]
    if len(files) > MOST_FILES or sum(require_regular(each) for each in files) > BYTES:
        raise BadInput(f"{path}: longer than {BYTES // MIB} MiB, or of too many files; cut it")
    left = BYTES
    for each in files:
        left -= _unpacked(each, left) if each.suffix.lower() == ".zstd" else 0
        _require_file(each)


def _require_file(path: Path) -> None:
    ending = path.suffix.lower()
    if ending == ".mcap":
        mcap_size.require_unpackable(path)
    elif ending == ".bag":
        _require_small(path, _chunks(path))
    elif ending == ".db3":
        _require_tables(path)


def _unpacked(path: Path, most: int) -> int:
    """Bytes of a packed file; BadInput where they are more than `most`, or no sound log."""
    with tempfile.TemporaryDirectory() as folder, opened(path) as file:
        made, size = Path(folder) / path.stem, 0
        with made.open("wb") as whole:
            for block in _blocks(_unpacker(b"zstd", file)):
                size += whole.write(block)
                if size > most:
                    raise BadInput(f"{path}: unpacks to more than {BYTES // MIB} MiB; cut it")
        _require_file(made)
    return size


def _blocks(stream: Any) -> Iterator[bytes]:
    """Blocks of a stream; a damaged one ends where it does: the log's library says so."""
    try:
        while block := stream.read(BLOCK):
            yield block
    except Exception:
        return


def _require_small(path: Path, streams: Iterator[Any]) -> None:
    """Raise BadInput where streams have more than BYTES; damaged ones end where they do."""
    count = 0
    for stream in streams:
        for block in _blocks(stream):
            count += len(block)
            if count > BYTES:
                raise BadInput(f"{path}: unpacks to more than {BYTES // MIB} MiB; cut it")


def _unpacker(name: bytes, file: BinaryIO) -> Any:
    if name == b"bz2":
        return bz2.BZ2File(file)
    if name == b"lz4":
        return library("lz4.frame", "formats").LZ4FrameFile(file)
    if name == b"zstd":
        unpacker = library("zstandard", "formats").ZstdDecompressor()
        return unpacker.stream_reader(file, read_across_frames=True)
    return file


def _chunks(path: Path) -> Iterator[Any]:
    """The chunks of a ROS 1 bag, each as a stream of what it unpacks to."""
    with opened(path, "a ROS bag") as file:
        file.readline(100)
        while (head := _block(file, LONGEST_HEAD)) is not None:
            fields = dict(_fields(head))
            size = file.read(LENGTH.size)
            if len(size) < LENGTH.size:
                return
            length = LENGTH.unpack(size)[0]
            end = file.seek(0, 1) + length
            if fields.get(b"op") == IS_CHUNK:
                data = io.BytesIO(file.read(min(length, BYTES)))
                yield _unpacker(fields.get(b"compression", b""), data)
            file.seek(end)


def _block(file: BinaryIO, most: int) -> bytes | None:
    """Bytes with their length before them; None at the end, or where it is above `most`."""
    head = file.read(LENGTH.size)
    size = LENGTH.unpack(head)[0] if len(head) == LENGTH.size else most + 1
    return file.read(size) if size <= most else None


def _fields(head: bytes) -> Iterator[tuple[bytes, bytes]]:
    stream = io.BytesIO(head)
    while (field := _block(stream, len(head))) is not None:
        name, _, value = field.partition(b"=")
        yield name, value


def _require_tables(path: Path) -> None:
    """Raise BadInput where rows are computed rather than stored, or unpack to more than BYTES."""
    require_regular(path, "a ROS log")
    try:
        where = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
        with closing(sqlite3.connect(where, uri=True)) as base:
            made = " ".join(str(text).upper() for _, text in _stored(base, path))
            if any(word in made for word in (" VIRTUAL ", " GENERATED ", " AS ", "AS(")):
                raise BadInput(f"{path}: has tables that compute what they hold")
            rows = (io.BytesIO(data) for (data,) in base.execute("SELECT data FROM messages"))
            _require_small(path, (_unpacker(_packed(row), row) for row in rows))
    except (sqlite3.Error, TypeError, ValueError) as error:
        raise BadInput(f"{path}: cannot be read as a log of messages ({error})") from None


def _stored(base: sqlite3.Connection, path: Path) -> list[tuple[str, str]]:
    found = base.execute("SELECT type, sql FROM sqlite_master WHERE sql NOT NULL").fetchall()
    if any(kind not in ("table", "index") for kind, _ in found):
        raise BadInput(f"{path}: has views or triggers, which a log has not")
    return found


def _packed(row: io.BytesIO) -> bytes:
    """The name of a message's packing, by its first bytes."""
    return b"zstd" if row.getvalue()[:4] == b"\x28\xb5\x2f\xfd" else b""
