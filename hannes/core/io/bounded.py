"""The one way in which files are opened: regular ones, read in blocks, up to the limits.

Devices, sockets and named pipes are refused before they are opened: they may never end. Packed
files are unpacked in blocks, and no further than the limit.
"""

import codecs
import gzip
import io
import itertools
import os
import stat
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from hannes.core.errors import BadInput
from hannes.core.io.inputs import note
from hannes.core.io.limits import BYTES, LINE, MIB, SECONDS

BLOCK = 1 << 20  # bytes read at once


def require_regular(path: str | Path, what: str = "a file", most: int = BYTES) -> int:
    """Return the size of a regular file [bytes]; BadInput where it is none, or above `most`."""
    note(path)
    try:
        status = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        raise BadInput(f"{path}: expected {what}, there is no such file") from None
    except OSError as error:
        raise BadInput(f"{path!s:.300}: cannot be read: {error.strerror}") from None
    except ValueError:
        raise BadInput(f"{str(path)!r:.200}: is no name of a file") from None
    return _checked(path, status, what, most)


def _checked(path: str | Path, status: os.stat_result, what: str, most: int) -> int:
    if stat.S_ISDIR(status.st_mode):
        raise BadInput(f"{path}: expected {what}, this is a folder")
    if not stat.S_ISREG(status.st_mode):
        raise BadInput(f"{path}: expected {what}, this is a device, a socket or a named pipe")
    if status.st_size > most:
        raise BadInput(f"{path}: {_beyond(most)}")
    return status.st_size


@contextmanager
def opened(path: str | Path, what: str = "a file", most: int = BYTES) -> Iterator[BinaryIO]:
    """Yield a regular file of at most `most` bytes, as it lies there; BadInput otherwise.

    Faults of the system while it is read are BadInput too.
    """
    require_regular(path, what, most)
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            _checked(path, os.fstat(file.fileno()), what, most)  # it may have been replaced
            yield file
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror or error}") from None


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))


def read_bytes(path: str | Path, what: str = "a file", most: int = BYTES) -> bytes:
    """Return a file's bytes, unpacked where its name ends in .gz; BadInput if that fails."""
    return b"".join(blocks(path, what, most))


def blocks(path: str | Path, what: str = "a file", most: int = BYTES) -> Iterator[bytes]:
    """Yield a file's bytes block by block, unpacked where its name ends in .gz.

    Raises BadInput where more than `most` come, or the reading takes longer than SECONDS.
    """
    count, late = 0, deadline(path)
    with opened(path, what, most) as file:
        packed = str(path).lower().endswith(".gz")
        stream = gzip.GzipFile(fileobj=file) if packed else file
        while block := _block(path, stream):
            count += len(block)
            if count > most:
                raise BadInput(f"{path}: {_beyond(most)}")
            late()
            yield block


def deadline(path: str | Path) -> Callable[[], None]:
    """What raises BadInput once SECONDS have gone by from now."""
    end = time.monotonic() + SECONDS

    def late() -> None:
        if time.monotonic() > end:
            raise BadInput(f"{path}: still not read after {SECONDS} s; cut it into parts")

    return late


def _block(path: str | Path, stream: BinaryIO | gzip.GzipFile) -> bytes:
    try:
        return stream.read(BLOCK)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise BadInput(f"{path}: cannot be read: {error}") from None


def _beyond(most: int) -> str:
    size = f"{most // MIB} MiB" if most >= MIB else f"{most} bytes"
    return f"longer than {size}, packed or unpacked; cut it into shorter ones"


def lines(
    path: str | Path, encoding: str = "utf-8-sig", what: str = "a file", advice: str = ""
) -> Iterator[str]:
    """Yield the lines of a text file without their ends, whichever ends they have.

    Raises BadInput with the line's number for one that is no text in `encoding` (`advice` follows),
    or longer than LINE.
    """
    decoder = io.IncrementalNewlineDecoder(codecs.getincrementaldecoder(encoding)(), True)
    number, rest, late = 0, "", deadline(path)
    for block in itertools.chain(blocks(path, what), (b"",)):
        try:
            text = rest + decoder.decode(block, final=not block)
        except UnicodeError as error:
            line = number + 1 + _newlines(error)
            name = encoding.removesuffix("-sig")
            raise BadInput(f"{path}, line {line}: not {name} text{advice}") from None
        *whole, rest = text.split("\n")
        if len(rest) > LINE:
            raise BadInput(f"{path}, line {number + len(whole) + 1}: longer than {LINE} bytes")
        number += len(whole)
        for each in whole:
            yield each
            late()  # whoever reads may take long for each
    yield rest


def _newlines(error: UnicodeError) -> int:
    """Ends of lines before what could not be decoded."""
    if not isinstance(error, UnicodeDecodeError):
        return 0
    return error.object.count(b"\n", 0, error.start)
