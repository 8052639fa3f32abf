"""A board that is a program: real time, on a pseudo-terminal or a TCP socket."""

import contextlib
import os
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Machine, Settings
from hannes.bench.frames import Splitter, encode
from hannes.bench.misbehaviour import Cable, Misbehaviour
from hannes.bench.port import HOST, listening
from hannes.core.errors import BadInput

BEHIND = 0.1  # s that the board may be late before it misses the ticks that it is behind


class Far(Protocol):
    """The board's end of a cable."""

    address: str

    def read(self) -> bytes:
        """Bytes of the host that are there."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes to the host; those of which it takes no notice are lost."""
        ...

    def cut(self) -> None:
        """Let go of the host, as when a cable is pulled."""
        ...

    def close(self) -> None:
        """Close this end."""
        ...


class Terminal:
    """A pseudo-terminal; `address` is the device to open."""

    def __init__(self) -> None:
        try:
            import pty
            import tty
        except ImportError:
            raise BadInput("this system has no pseudo-terminals; use --tcp PORT") from None
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.address = os.ttyname(self._slave)

    def read(self) -> bytes:
        """Bytes of the host that are there."""
        with contextlib.suppress(OSError):
            return os.read(self._master, 65536)
        return b""

    def write(self, data: bytes) -> None:
        """Send bytes; a full terminal, which nobody reads, takes none."""
        with contextlib.suppress(OSError):
            os.write(self._master, data)

    def cut(self) -> None:
        """A terminal cannot be pulled; silence is all there is."""

    def close(self) -> None:
        """Close both ends."""
        for each in (self._master, self._slave):
            os.close(each)


class Socket:
    """A TCP socket on this machine alone, for one host at a time; port 0: any that is free.

    Raises BadInput where the port cannot be had.
    """

    def __init__(self, port: int) -> None:
        self._server = listening(port)
        self._server.setblocking(False)
        self._host: socket.socket | None = None
        self.address = f"socket://{HOST}:{self._server.getsockname()[1]}"

    def read(self) -> bytes:
        """Bytes of the host that are there; lets a first host in and turns a second one away."""
        with contextlib.suppress(OSError):
            found, _ = self._server.accept()
            found.setblocking(False)
            found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self._host is None:
                self._host = found
            else:
                found.close()
        if self._host is None:
            return b""
        try:
            data = self._host.recv(65536)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.cut()
        return data

    def write(self, data: bytes) -> None:
        """Send bytes."""
        if self._host is not None:
            with contextlib.suppress(OSError):
                self._host.send(data)

    def cut(self) -> None:
        """Let go of the host."""
        if self._host is not None:
            self._host.close()
            self._host = None

    def close(self) -> None:
        """Close the socket."""
        self.cut()
        self._server.close()


@dataclass
class VirtualBoard:
    """A machine behind the rules of a board, at one end of a cable.

    `make` builds the machine: a reset builds it anew. A board that gets no processor for a while
    stands still, machine and clock; with `on_time` its clock goes on, as that of hardware does, and
    what it did not send is missing.
    """

    make: Callable[[], Machine]
    far: Far
    settings: Settings
    how: Misbehaviour
    on_time: bool = False

    def __post_init__(self) -> None:
        self.cable = Cable(self.how)
        self.logic = BoardLogic(self.make(), self.settings)
        self._splitter = Splitter(HOST_LENGTHS)
        self._damaged = 0
        self._reset_done = not self.how.reset
        self.ticks, self.moment = 0, 0.0

    def run(self, until: Callable[[], bool]) -> None:
        """Tick in real time until `until` says so."""
        period = (1.0 - self.how.drift) / self.settings.rate
        began = following = time.monotonic()
        while not until():
            self.once(time.monotonic() - began)
            following += period
            ahead = following - time.monotonic()
            if ahead > 0.0:
                time.sleep(ahead)
            elif ahead < -BEHIND:
                ticks = int(-ahead / period)
                self.logic.missed(ticks if self.on_time else 0)
                following += ticks * period

    def once(self, moment: float) -> None:
        """Hear, tick and send once, `moment` [s] after the beginning."""
        self.ticks += 1
        self.moment = moment
        data = self.far.read()
        out = self.cable.is_out(moment)
        if out:
            self.far.cut()
        if not self._reset_done and moment >= self.how.reset:
            self._reset_done = True
            self.logic = BoardLogic(self.make(), self.settings)
        heard = [] if out else self._splitter.feed(data)
        self.logic.damaged(self._splitter.damaged - self._damaged)
        self._damaged = self._splitter.damaged
        answers = [answer for frame in heard for answer in self.logic.hear(frame)]
        packets = [encode(frame) for frame in [*answers, *self.logic.tick()]]
        if sent := self.cable.send(packets, moment):
            self.far.write(sent)
