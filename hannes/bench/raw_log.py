"""Bytes as they came, with a stamp a read: what every recording is made of, live or afterwards.

A line of JSON says what follows; then one record after another: host time [ns] u64, direction u8
(0: from the board, 1: to it, 2: an event in words, 3: a tactor's command), length u32, the bytes.
A log that ends within a record was cut off there; all before it counts. So it does where there is
what no record can begin with: the log is damaged there, and the rest is left out.
"""

import json
import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.bounded import BLOCK, require_regular
from hannes.core.io.json_text import parsed

RECORD = struct.Struct("<QBI")
SCHEMA = "hannes-raw-log-1"
FROM_BOARD, TO_BOARD, EVENT, HAPTIC = 0, 1, 2, 3
LARGEST = 1 << 24  # bytes of one record: more is no log


@dataclass(frozen=True)
class Record:
    """One read, write or event: host time [ns], direction, bytes."""

    time: int
    direction: int
    data: bytes


class RawLogWriter:
    """Writes a raw log; every record is handed to the system at once, so that a kill loses none."""

    def __init__(self, path: str | Path, about: dict[str, Any]) -> None:
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
        self._file = os.open(path, flags | getattr(os, "O_BINARY", 0), 0o644)
        os.write(self._file, json.dumps({"schema": SCHEMA, **about}).encode() + b"\n")

    def add(self, time: int, direction: int, data: bytes) -> None:
        """Append one record."""
        os.write(self._file, RECORD.pack(time, direction, len(data)) + data)

    def close(self) -> None:
        """Close the file, on disk."""
        os.fsync(self._file)
        os.close(self._file)


class RawLogReader:
    """Reads a raw log from its start, also while it is being written.

    `about` is its first line, `size` its bytes then, `read_up_to` the byte at which the records
    that were returned end; `damaged`: it goes on there with what is no record. Raises BadInput
    where it is no raw log.
    """

    def __init__(self, path: str | Path) -> None:
        self.size = require_regular(path, "a raw log")
        self._file = open(path, "rb")
        line = self._file.readline(65536)
        try:
            self.about = parsed(line)
            known = self.about.get("schema") == SCHEMA
        except (ValueError, AttributeError):
            known = False
        if not known:
            self._file.close()
            raise BadInput(f"{path}: this is no raw log of `hannes record` (expected {SCHEMA})")
        self._path, self._rest = path, b""
        self.head = self.read_up_to = len(line)
        self.damaged = False

    def records(self) -> Iterator[Record]:
        """Whole records that are there and were not yet returned, up to a damage.

        Raises BadInput where the very first is none.
        """
        while not self.damaged and (block := self._file.read(BLOCK)):
            self._rest += block
            yield from self._whole()

    def _whole(self) -> Iterator[Record]:
        """Whole records among the bytes that were read."""
        at = 0
        while len(self._rest) - at >= RECORD.size:
            time, direction, length = RECORD.unpack_from(self._rest, at)
            if not 0 < length <= LARGEST or direction > HAPTIC:
                self._require_some(length)
                self.damaged = True
                break
            if len(self._rest) - at - RECORD.size < length:
                break
            start = at + RECORD.size
            self.read_up_to += RECORD.size + length
            yield Record(time, direction, self._rest[start : start + length])
            at = start + length
        self._rest = b"" if self.damaged else self._rest[at:]

    def _require_some(self, length: int) -> None:
        """Raise BadInput where the log is damaged at its head."""
        if self.read_up_to == self.head:
            raise BadInput(
                f"{self._path}: begins with a record of {length} bytes; the log is damaged there, "
                "and nothing can be recovered"
            )

    def left_out(self) -> str:
        """What was left out of a log that was read to its end, in words; empty for a whole one."""
        left = self.size - self.read_up_to
        if left <= 0:
            return ""
        what = "the log is damaged" if self.damaged else "the log was cut off within a record"
        return f"{what} at byte {self.read_up_to}: the {left} bytes from there on are left out"

    def close(self) -> None:
        """Close the file."""
        self._file.close()
