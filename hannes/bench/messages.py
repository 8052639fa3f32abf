"""What frames carry: the payload of every kind, each of a fixed length.

A board introduces itself by one Hello and one Channel for each that it measures; only then is the
length of its telemetry known. `docs/reference/protocol.md` is generated from this file.
"""

import struct
from dataclasses import astuple, dataclass
from enum import IntEnum
from typing import ClassVar, Self

VERSION = 1  # of the protocol


class Kind(IntEnum):
    """Kinds of frames; those below 32 are the host's, the others the board's."""

    ASK = 1  # introduce yourself
    ALIVE = 2  # the host is there; feeds the watchdog
    PROFILE = 3  # a reference profile follows
    POINTS = 4  # eight of its points
    START = 5  # run the profile that was sent
    SET_POINT = 6  # follow this reference now
    STOP = 7  # open the drive
    RESEND = 8  # send these frames again from the ring
    HELLO = 32
    CHANNEL = 33
    TELEMETRY = 34
    PULSE = 35  # the board is there, and in which state
    ANSWER = 36  # what became of a request


class State(IntEnum):
    """What the board does."""

    IDLE = 0
    RUNNING = 1  # a profile
    FOLLOWING = 2  # set points
    STOPPED = 3  # asked for by the host
    WATCHDOG = 4  # no word from the host for too long
    OVER_CURRENT = 5
    OVER_TEMPERATURE = 6
    OVER_TRAVEL = 7


class Reason(IntEnum):
    """Why a request was refused, or that it was not."""

    DONE = 0
    UNKNOWN = 1
    INCOMPLETE = 2  # a start before the whole profile came
    BEYOND_LIMITS = 3
    BUSY = 4
    NOT_KEPT = 5  # frames that the ring no longer holds
    TOO_LONG = 6  # a profile of more points than the board keeps


@dataclass(frozen=True)
class _Payload:
    """Packs its fields by `FORMAT`; texts are UTF-8, filled up with zeros."""

    FORMAT: ClassVar[struct.Struct]
    KIND: ClassVar[Kind]

    def pack(self) -> bytes:
        """Return the payload's bytes."""
        flat: list[object] = []
        for value in astuple(self):
            if isinstance(value, str):
                flat.append(value.encode())
            elif isinstance(value, tuple):
                flat.extend(number for pair in value for number in pair)
            else:
                flat.append(value)
        return self.FORMAT.pack(*flat)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Return the message in `payload`, whose length was checked."""
        values = cls.FORMAT.unpack(payload)
        return cls(*(_text(v) if isinstance(v, bytes) else v for v in values))


def _text(raw: bytes) -> str:
    return raw.rstrip(b"\x00").decode(errors="replace")


@dataclass(frozen=True)
class Ask(_Payload):
    """Host: introduce yourself."""

    version: int = VERSION
    FORMAT: ClassVar = struct.Struct("<H")
    KIND: ClassVar = Kind.ASK


@dataclass(frozen=True)
class Alive(_Payload):
    """Host: still here; `beat` comes back in the next pulse, which gives the round trip."""

    beat: int
    FORMAT: ClassVar = struct.Struct("<I")
    KIND: ClassVar = Kind.ALIVE


@dataclass(frozen=True)
class Profile(_Payload):
    """Host: a profile of `points` points follows, whose CRC-32 is `check`; it ends after
    `duration` [us]."""

    points: int
    duration: int
    check: int
    FORMAT: ClassVar = struct.Struct("<III")
    KIND: ClassVar = Kind.PROFILE


AT_ONCE = 8  # points in one frame


@dataclass(frozen=True)
class Points(_Payload):
    """Host: points from number `first` on: time [us] and reference at the output shaft [urad].

    Where fewer are left the last is repeated.
    """

    first: int
    points: tuple[tuple[int, int], ...]
    FORMAT: ClassVar = struct.Struct("<I" + "Ii" * AT_ONCE)
    KIND: ClassVar = Kind.POINTS

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Return the points in `payload`."""
        first, *flat = cls.FORMAT.unpack(payload)
        return cls(first, tuple(zip(flat[::2], flat[1::2], strict=True)))


@dataclass(frozen=True)
class Start(_Payload):
    """Host: run the profile whose CRC-32 is `check`."""

    check: int
    FORMAT: ClassVar = struct.Struct("<I")
    KIND: ClassVar = Kind.START


@dataclass(frozen=True)
class SetPoint(_Payload):
    """Host: follow `reference` [urad at the output shaft] until the next set point."""

    reference: int
    FORMAT: ClassVar = struct.Struct("<i")
    KIND: ClassVar = Kind.SET_POINT


@dataclass(frozen=True)
class Stop(_Payload):
    """Host: open the drive."""

    reason: int = 0
    FORMAT: ClassVar = struct.Struct("<B")
    KIND: ClassVar = Kind.STOP


@dataclass(frozen=True)
class Resend(_Payload):
    """Host: send `count` frames again, from sequence number `first` on."""

    first: int
    count: int
    FORMAT: ClassVar = struct.Struct("<IH")
    KIND: ClassVar = Kind.RESEND


@dataclass(frozen=True)
class Hello(_Payload):
    """Board: what it is. Rate [Hz] of telemetry and control, watchdog [us], ring [frames]."""

    version: int
    firmware: str
    rate: int
    watchdog: int
    ring: int
    profile_points: int
    channels: int
    FORMAT: ClassVar = struct.Struct("<H24sIIIIB")
    KIND: ClassVar = Kind.HELLO


@dataclass(frozen=True)
class Channel(_Payload):
    """Board: one measured channel: value [unit] = raw * scale; `code` as in Python's struct."""

    index: int
    name: str
    unit: str
    code: str
    scale: float
    FORMAT: ClassVar = struct.Struct("<B16s8s1sd")
    KIND: ClassVar = Kind.CHANNEL


@dataclass(frozen=True)
class Pulse(_Payload):
    """Board: its state, the last beat heard, commands refused, frames that did not fit."""

    state: int
    beat: int
    refused: int
    dropped: int
    FORMAT: ClassVar = struct.Struct("<BIII")
    KIND: ClassVar = Kind.PULSE


@dataclass(frozen=True)
class Answer(_Payload):
    """Board: what became of the request with sequence number `request`."""

    request: int
    kind: int
    reason: int
    FORMAT: ClassVar = struct.Struct("<IBB")
    KIND: ClassVar = Kind.ANSWER


FROM_HOST = (Ask, Alive, Profile, Points, Start, SetPoint, Stop, Resend)
FROM_BOARD = (Hello, Channel, Pulse, Answer)


def lengths(messages: tuple[type[_Payload], ...]) -> dict[int, int]:
    """Payload length [bytes] by kind."""
    return {message.KIND: message.FORMAT.size for message in messages}


@dataclass(frozen=True)
class Telemetry:
    """How a board's telemetry is laid out: its channels in order."""

    channels: tuple[Channel, ...]

    @property
    def format(self) -> struct.Struct:
        """Layout of the payload."""
        return struct.Struct("<" + "".join(channel.code for channel in self.channels))

    def unpack(self, payload: bytes) -> tuple[float, ...]:
        """Return the values [the channels' units] in `payload`."""
        raw = self.format.unpack(payload)
        return tuple(round(n * c.scale, 12) for n, c in zip(raw, self.channels, strict=True))

    def pack(self, values: tuple[float, ...]) -> bytes:
        """Return the payload of `values` [the channels' units], held within the codes' ranges."""
        return self.format.pack(*(_raw(v, c) for v, c in zip(values, self.channels, strict=True)))


_BITS = {"b": 8, "h": 16, "i": 32, "q": 64}


def _raw(value: float, channel: Channel) -> float | int:
    scaled = value / channel.scale
    if channel.code in "fd":
        return scaled
    signed = channel.code.lower()
    low, high = -(1 << (_BITS[signed] - 1)), (1 << (_BITS[signed] - 1)) - 1
    if channel.code != signed:
        low, high = 0, (1 << _BITS[signed]) - 1
    return min(max(round(scaled), low), high)
