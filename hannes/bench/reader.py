"""The process that owns the port: it writes down what comes, feeds the watchdog, and obeys.

Nothing else runs in it, its garbage collector stands still, and its priority is raised where the
system allows: what is slow (display, recognition, files) reads the raw log from another process.
It ends, and stops the board, when the program that started it does, however that ended. It feeds
the watchdog only while that program gives signs of life: one that hangs has the board stopped.
"""

import contextlib
import gc
import multiprocessing
import os
import signal
from collections.abc import Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from hannes.bench.adapters import adapter
from hannes.bench.events import Adapter, Status
from hannes.bench.messages import State
from hannes.bench.port import LinkLost, Port, now
from hannes.bench.raw_log import EVENT, FROM_BOARD, HAPTIC, TO_BOARD, RawLogWriter
from hannes.core.errors import BadInput, ComputationFailed

NANO = 1e-9
HERE = HAPTIC + 1  # in place of a record's direction: a sign of life
BEAT = 0.05  # s between two words to the board
SIGN = 0.05  # s between two signs of life of the deciding process
SILENT = 1.0  # s without one after which the board is stopped
PATIENCE = 1.0  # s in which a stop must be seen in the telemetry
SEEN, SENT, UNSENT = 0, 3, 4  # exit status of the process: a stop was seen, only sent, not that
RETRY = 0.2  # s between two tries to open a port that went away


@dataclass(frozen=True)
class Link:
    """Where a board is and how to speak to it; seconds to wait for one that went away.

    real_time: whether the reader asks for real-time priority.
    """

    port: str
    board: str = "hannes"
    options: dict[str, Any] = field(default_factory=dict)
    baud: int = 0
    reconnect: float = 0.0
    real_time: bool = True

    def adapter(self) -> Adapter:
        """A new adapter for this board."""
        return adapter(self.board, **self.options)


class Reader:
    """Handle on the reader's process: send bytes to the board, end it.

    Raises BadInput on creation where the port cannot be opened, ComputationFailed where the process
    ends before that. `notes`: priority and latency.
    """

    def __init__(self, link: Link, log: str | Path, about: Mapping[str, Any] | None = None) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(
            target=_run, args=(link, str(log), dict(about or {}), far), name="hannes-reader"
        )
        self._process.start()
        far.close()
        try:
            kind, said = self._pipe.recv()
        except EOFError:
            self._process.join()
            raise ComputationFailed(
                "the process that reads the port ended before it began"
            ) from None
        if kind == "refused":
            self._process.join()
            raise BadInput(said)
        self.notes: list[str] = said
        self.stop_sent = False  # whether one was written to the port, once closed
        self._signed = 0

    @property
    def pid(self) -> int:
        """Number of the process."""
        return int(self._process.pid or 0)

    def send(self, data: bytes) -> None:
        """Hand bytes over for the board; harmless where the reader has ended."""
        with contextlib.suppress(OSError):
            self._pipe.send_bytes(bytes([TO_BOARD]) + data)

    def write_down(self, direction: int, data: bytes) -> None:
        """Hand a record over for the raw log; harmless where the reader has ended."""
        with contextlib.suppress(OSError):
            self._pipe.send_bytes(bytes([direction]) + data)

    def here(self) -> None:
        """Give a sign of life where one is due: to be called at least every SILENT seconds."""
        if now() - self._signed > SIGN / NANO:
            self._signed = now()
            self.write_down(HERE, b"")

    def is_alive(self) -> bool:
        """Whether the process still runs."""
        return self._process.is_alive()

    def close(self) -> bool:
        """Stop the board, wait until its telemetry shows it, end; False where it was not seen."""
        with contextlib.suppress(OSError):
            self._pipe.send_bytes(b"")
        self._process.join(PATIENCE + 5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self.stop_sent = self._process.exitcode in (SEEN, SENT)
        return self._process.exitcode == SEEN


def _run(link: Link, log: str, said: dict[str, Any], pipe: Connection) -> None:
    """Body of the process; its exit status says whether the board was seen to stop."""
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)  # the parent decides; its end is seen in the pipe
    try:
        port = Port(link.port, link.baud or link.adapter().baud)
    except BadInput as error:
        pipe.send(("refused", str(error)))
        return
    notes = [port.notes, raise_priority() if link.real_time else "priority: ordinary (as asked)"]
    about = {"port": link.port, "board": link.board, "options": link.options, "notes": notes}
    writer = RawLogWriter(log, {**said, **about, "start_ns": now()})
    gc.collect()
    gc.freeze()
    gc.disable()
    pipe.send(("ready", notes))
    status = _Loop(link, port, writer, pipe).run()
    writer.close()
    raise SystemExit(status)


def raise_priority() -> str:
    """Ask for real time, else for a nicer nice; say which there is."""
    with contextlib.suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        return "priority: real time (FIFO 10)"
    with contextlib.suppress(AttributeError, OSError):
        return f"priority: nice {os.nice(-10)}"
    return "priority: ordinary (the system allows no more)"


class _Loop:
    """Read, write down, beat, obey."""

    def __init__(self, link: Link, port: Port, writer: RawLogWriter, pipe: Connection) -> None:
        self.link, self.port, self.writer, self.pipe = link, port, writer, pipe
        self.speaker, self.listener = link.adapter(), link.adapter()
        self.beat, self.beaten, self.polled = 0, 0, 0
        self.ending, self.status = 0, UNSENT
        self.signed, self.silent = now(), False

    def run(self) -> int:
        """Go on until stopped, the parent is gone, or the link is lost for good; exit status."""
        while True:
            try:
                self._once()
            except LinkLost as error:
                self._event(str(error))
                if self.ending or not self._reopened():
                    return self.status
            late = self.ending and now() - self.ending > PATIENCE / NANO
            if self.status == SEEN or late:
                self.port.close()
                return self.status

    def _once(self) -> None:
        data = self.port.read()
        stamp = now()
        if data:
            self.writer.add(stamp, FROM_BOARD, data)
            if self.ending:
                self._look_for_stop(data, stamp)
        if stamp - self.beaten > BEAT / NANO:
            self.beaten, self.beat = stamp, self.beat + 1
            self._watch(stamp)
            if not self.silent:
                self._write(self.speaker.alive(self.beat))
            if self.ending or self.silent:
                self._stop()
        if self.speaker.polls and stamp - self.polled > self.speaker.polls / NANO:
            self.polled = stamp
            self._write(self.speaker.poll())
        self._obey(stamp)

    def _watch(self, stamp: int) -> None:
        """Note whether the deciding process hangs, and when it does so no more."""
        silent = not self.ending and stamp - self.signed > SILENT / NANO
        if silent and not self.silent:
            self._event(f"the deciding process hung for {SILENT:g} s, so the board is stopped")
        self.silent = silent

    def _obey(self, stamp: int) -> None:
        """Pass on what the parent sends; an empty message or its end means: stop and end."""
        try:
            while not self.ending and self.pipe.poll():
                data = self.pipe.recv_bytes()
                self.signed = stamp
                if not data:
                    self._end(stamp)
                elif data[0] == TO_BOARD:
                    self._write(data[1:])
                elif data[0] != HERE:
                    self.writer.add(stamp, data[0], data[1:])
        except (EOFError, OSError):
            self._end(stamp)

    def _end(self, stamp: int) -> None:
        self.ending = stamp
        self._stop()

    def _stop(self) -> None:
        self._write(self.speaker.stop())
        if self.ending and self.status == UNSENT:
            self.status = SENT

    def _look_for_stop(self, data: bytes, stamp: int) -> None:
        """Only STOPPED follows from a stop: IDLE may have been said before the board heard of it.

        Boards that say no state have stopped as far as can be seen once they were asked.
        """
        for event in self.listener.feed(data, stamp * NANO):
            if isinstance(event, Status) and event.state is State.STOPPED:
                self.status = SEEN
        if self.link.board != "hannes":
            self.status = SEEN

    def _write(self, data: bytes) -> None:
        if data:
            self.writer.add(now(), TO_BOARD, data)
            self.port.write(data)

    def _event(self, words: str) -> None:
        self.writer.add(now(), EVENT, words.encode())

    def _reopened(self) -> bool:
        """Try to open the port again for as long as was asked."""
        import time

        self.port.close()
        until = now() + self.link.reconnect / NANO
        while now() < until:
            time.sleep(RETRY)
            with contextlib.suppress(BadInput):
                self.port = Port(self.link.port, self.link.baud or self.speaker.baud)
                self._event("the link is back")
                return True
        return False
