"""Frames on the wire: COBS between zero bytes, a header, a payload of known length, a CRC-32.

    COBS( kind u8 | sequence u32 | board time u64 [us] | payload | CRC-32 u32 ) 00

All numbers are little-endian. COBS (Cheshire & Baker 1999) leaves no zero byte inside a frame, so
that a reader finds the next frame after any damage. The CRC (zlib's) covers header and payload.
A frame counts only if its kind is known, its length is exactly that of its kind, and its CRC is
right.
"""

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

HEADER = struct.Struct("<BIQ")  # kind, sequence number, board time [us]
CHECK = struct.Struct("<I")
LONGEST = 254  # bytes of a frame before COBS: one byte of overhead, then the zero
ANY = -1  # in place of a length, where none is known yet


@dataclass(frozen=True)
class Frame:
    """One frame that passed its checks; `time` is the board's clock [us]."""

    kind: int
    sequence: int
    time: int
    payload: bytes


def encode(frame: Frame) -> bytes:
    """Return the bytes of `frame` on the wire, its closing zero included.

    Raises ValueError where it is longer than LONGEST.
    """
    from cobs import cobs

    body = HEADER.pack(frame.kind, frame.sequence, frame.time) + frame.payload
    if len(body) + CHECK.size > LONGEST:
        raise ValueError(f"a frame of {len(body) + CHECK.size} bytes; at most {LONGEST}")
    return cobs.encode(body + CHECK.pack(zlib.crc32(body))) + b"\x00"


def decode(packet: bytes, lengths: Mapping[int, int]) -> Frame | None:
    """Return the frame in `packet` (no zero byte), or None where it fails one of its checks.

    lengths: payload length [bytes] of every kind that may come, or ANY.
    """
    from cobs import cobs

    try:
        body = cobs.decode(packet)
    except cobs.DecodeError:
        return None
    size = len(body) - HEADER.size - CHECK.size
    if size < 0 or lengths.get(body[0]) not in (size, ANY):
        return None
    if zlib.crc32(body[: -CHECK.size]) != CHECK.unpack_from(body, len(body) - CHECK.size)[0]:
        return None
    kind, sequence, time = HEADER.unpack_from(body)
    return Frame(kind, sequence, time, body[HEADER.size : -CHECK.size])


class Splitter:
    """Cuts a stream of bytes into frames; `damaged` counts what failed its checks.

    `lengths` may grow while the stream is read: a hello says how long telemetry is.
    """

    def __init__(self, lengths: Mapping[int, int]) -> None:
        self.lengths = lengths
        self.damaged = 0
        self._rest = bytearray()

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that end within `data`, in the order of their arrival."""
        *packets, rest = (bytes(self._rest) + data).split(b"\x00")
        self._rest = bytearray(rest[: LONGEST + 2])  # longer is no frame: it fails at its end
        frames = []
        for packet in packets:
            if not packet:
                continue
            frame = decode(packet, self.lengths)
            self.damaged += frame is None
            if frame is not None:
                frames.append(frame)
        return frames
