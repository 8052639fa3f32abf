"""What a board's bytes say, whatever its protocol: an adapter turns one into the other."""

from dataclasses import dataclass
from typing import Protocol

from hannes.bench.messages import Reason, State


@dataclass(frozen=True)
class About:
    """What a board says of itself: channels and their units; rate [Hz]; watchdog [s]."""

    firmware: str
    channels: dict[str, str]
    rate: float
    watchdog: float


@dataclass(frozen=True)
class Row:
    """One sample: number of the frame, board time [s], values in the order of the channels."""

    number: int
    time: float
    values: tuple[float, ...]


@dataclass(frozen=True)
class Status:
    """State of the board, at its time [s]; `beat` is the last one that it heard."""

    time: float
    state: State
    beat: int
    refused: int
    dropped: int


@dataclass(frozen=True)
class Reply:
    """What became of the request with number `request`, at board time [s]."""

    time: float
    request: int
    kind: int
    reason: Reason


@dataclass(frozen=True)
class OtherVersion:
    """The board speaks another version of the protocol."""

    version: int


@dataclass(frozen=True)
class Restarted:
    """The board began anew, a reset for instance; its clock says this time [s]."""

    time: float


Event = About | Row | Status | Reply | OtherVersion | Restarted


class Adapter(Protocol):
    """One kind of board: what to send, and what its bytes say.

    The methods that make bytes number their requests; `feed` depends on the bytes alone, so that a
    raw log read again says the same.
    """

    name: str
    baud: int
    polls: float  # s between two calls of `poll`; 0 for a board that speaks by itself

    def ask(self) -> bytes:
        """Bytes that make the board introduce itself."""
        ...

    def alive(self, beat: int) -> bytes:
        """Bytes that feed the watchdog."""
        ...

    def poll(self) -> bytes:
        """Bytes that ask for the next sample."""
        ...

    def profile(self, points: list[tuple[float, float]]) -> list[bytes]:
        """Packets that send a profile of (time [s], reference [rad]); empty where it has none."""
        ...

    def start(self) -> bytes:
        """Bytes that run the profile sent last."""
        ...

    def set_point(self, reference: float) -> bytes:
        """Bytes that make the board follow `reference` [rad at the output shaft]."""
        ...

    def stop(self) -> bytes:
        """Bytes that open the drive."""
        ...

    def resend(self, first: int, count: int) -> bytes:
        """Bytes that ask for frames again; empty where the board keeps none."""
        ...

    def feed(self, data: bytes, host_time: float) -> list[Event]:
        """What `data` says, which came at `host_time` [s]."""
        ...

    @property
    def damaged(self) -> int:
        """Frames or lines so far that failed their checks."""
        ...

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Intervals of frame numbers that never came."""
        ...
