"""A conversation with a board: who it is, a profile run to its end, its answers."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hannes.bench.events import About, Adapter, Event, Reply, Restarted, Row, Status
from hannes.bench.messages import VERSION, Kind, Reason, State
from hannes.bench.raw_log import EVENT, FROM_BOARD, RawLogReader
from hannes.bench.reader import NANO, Link, Reader
from hannes.core.errors import BadInput, ComputationFailed, HannesError, Interrupted

HELLO_TIME = 2.0  # s within which a board introduces itself
ASK_AGAIN = 0.25  # s
POLL = 0.005  # s between two looks at the raw log
ENDED = {
    State.WATCHDOG: "its watchdog: it heard nothing from this machine for too long",
    State.OVER_CURRENT: "its current limit",
    State.OVER_TEMPERATURE: "its temperature limit",
    State.OVER_TRAVEL: "its travel limit",
    State.STOPPED: "a stop that it was sent",
}


@dataclass
class Heard:
    """What a board said so far; `bytes` counts what came, sense or not; `restarts`: its resets."""

    about: About | None = None
    status: Status | None = None
    replies: list[Reply] = field(default_factory=list)
    rows: int = 0
    bytes: int = 0
    restarts: int = 0
    version: int = VERSION
    lost: str = ""


class Session:
    """Reader process, its raw log read as it grows, and requests that are answered."""

    def __init__(self, link: Link, log: str | Path, about: Mapping[str, Any] | None = None) -> None:
        self.link, self.log = link, Path(log)
        self.reader = Reader(link, log, about)
        self.speaker: Adapter = link.adapter()
        self._listener: Adapter = link.adapter()
        self._follow = RawLogReader(log)
        self.heard = Heard()
        self.read_up_to = 0  # host time of the newest record that was read [ns]
        self.watch: Callable[[Event], None] = lambda event: None  # is shown every event
        self._stopped: bool | None = None  # seen or not, once closed
        self._unread = self._fresh()

    def events(self) -> Iterator[Event]:
        """What has come since the last look, which may be left and gone on with.

        To be asked at least once a second: see `Reader`.
        """
        self.reader.here()
        while (event := next(self._unread, None)) is not None:
            yield event
        self._unread = self._fresh()

    def _fresh(self) -> Iterator[Event]:
        for record in self._follow.records():
            self.read_up_to = record.time
            if record.direction != FROM_BOARD:
                if record.direction == EVENT:
                    self.heard.lost = record.data.decode(errors="replace")
                continue
            self.reader.here()
            self.heard.bytes += len(record.data)
            for event in self._listener.feed(record.data, record.time * NANO):
                self._note(event)
                self.watch(event)
                yield event

    def wait(self, done: Callable[[], bool], seconds: float) -> bool:
        """Look until `done` or the time is over; says whether it was done."""
        until = time.monotonic() + seconds
        while True:
            for _ in self.events():
                if time.monotonic() > until:
                    break  # it comes quicker than it is read
            if done():
                return True
            if time.monotonic() > until or not self.reader.is_alive():
                return done()
            time.sleep(POLL)

    def hello(self) -> About:
        """Wait for the board to introduce itself; BadInput says what came instead."""
        for _ in range(round(HELLO_TIME / ASK_AGAIN)):
            self.reader.send(self.speaker.ask())
            if self.wait(lambda: self.heard.about is not None or self._other(), ASK_AGAIN):
                break
        if self.heard.about is None or self._other():
            raise BadInput(self._stranger())
        return self.heard.about

    def profile(self, points: list[tuple[float, float]]) -> Reply:
        """Send a whole profile of (time [s], reference [rad]) and start it.

        Returns the board's answer to the start. Raises BadInput where it is refused.
        """
        for packet in self.speaker.profile(points):
            self.reader.send(packet)
        self.reader.send(self.speaker.start())
        answered = self.wait(lambda: bool(self._answers(Kind.START)), HELLO_TIME)
        if not answered:
            raise ComputationFailed(f"{self.link.port}: no answer to the start within 2 s")
        answer = self._answers(Kind.START)[-1]
        if answer.reason is not Reason.DONE:
            raise BadInput(
                f"{self.link.port}: the board refuses the profile "
                f"({answer.reason.name.lower().replace('_', ' ')})"
            )
        return answer

    def run_to_end(self, seconds: float) -> None:
        """Wait until the board is idle again; ComputationFailed where something stopped it."""
        before = self.heard.restarts
        self.wait(
            lambda: self._state() not in (State.RUNNING, None) or self.heard.restarts > before,
            seconds + HELLO_TIME,
        )
        self._require_one_life(before)
        state = self._state()
        if state in ENDED:
            raise ComputationFailed(f"{self.link.port}: the board was stopped by {ENDED[state]}")
        if not self.reader.is_alive():
            raise ComputationFailed(self.heard.lost or f"{self.link.port}: the link was lost")

    @property
    def damaged(self) -> int:
        """Frames of the board so far that failed their checks."""
        return self._listener.damaged

    @property
    def gaps(self) -> int:
        """Intervals of frames so far that never came."""
        return len(self._listener.missing)

    def require_following(self) -> None:
        """Raise ComputationFailed where the board was stopped, or the link is lost."""
        self._require_one_life(0)
        status = self.heard.status
        if status is not None and status.state in ENDED and self._set_points(status.time):
            raise ComputationFailed(
                f"{self.link.port}: the board was stopped by {ENDED[status.state]}"
            )
        if not self.reader.is_alive():
            raise ComputationFailed(self.heard.lost or f"{self.link.port}: the link was lost")

    def _require_one_life(self, before: int) -> None:
        if self.heard.restarts > before:
            raise ComputationFailed(
                f"{self.link.port}: the board began anew, and let the hand go; was it reset, or is "
                "its supply too weak?"
            )

    def _set_points(self, before: float) -> bool:
        """Whether a set point was accepted before this board time [s]."""
        return any(
            reply.time < before and reply.reason is Reason.DONE
            for reply in self._answers(Kind.SET_POINT)[:1]
        )

    def close(self) -> bool:
        """Stop the board and end the reader; False where the stop was not seen."""
        if self._stopped is None:
            self._stopped = self.reader.close()
            for _ in self.events():
                pass
            self._follow.close()
        return self._stopped

    def stop_in_words(self) -> str:
        """What became of the stop that `close` asks for, for the user."""
        port = self.link.port
        if self._stopped and self.link.board == "hannes":
            return "the hand was stopped, as the board's telemetry shows"
        if self._stopped:
            return f"a stop was sent to {port}, a board that says no state: look at the hand"
        if self.reader.stop_sent:
            return f"a stop was sent to {port}, but not seen in the telemetry: look at the hand"
        return (
            f"no stop could be sent to {port}: look at the hand, which only its board's own "
            "watchdog stops now"
        )

    def _note(self, event: Event) -> None:
        heard = self.heard
        if isinstance(event, Row):
            heard.rows += 1
        elif isinstance(event, Status):
            heard.status = event
        elif isinstance(event, About):
            heard.about = event
        elif isinstance(event, Reply):
            heard.replies.append(event)
        elif isinstance(event, Restarted):
            heard.restarts, heard.status, heard.replies = heard.restarts + 1, None, []
        else:
            heard.version = event.version

    @property
    def moved(self) -> bool:
        """Whether the board was seen to take a start or a set point."""
        return any(
            each.reason is Reason.DONE and each.kind in (Kind.START, Kind.SET_POINT)
            for each in self.heard.replies
        )

    def _answers(self, kind: Kind) -> list[Reply]:
        return [reply for reply in self.heard.replies if reply.kind == kind]

    def _state(self) -> State | None:
        """State of the board after its last answer to a start, None before there is any."""
        status, answers = self.heard.status, self._answers(Kind.START)
        if status is None or (answers and status.time <= answers[-1].time):
            return None
        return status.state

    def _other(self) -> bool:
        return self.heard.version != VERSION

    def _stranger(self) -> str:
        """Why there was no hello: silence, no frame among the bytes, another version."""
        port, heard = self.link.port, self.heard
        if self._other():
            return (
                f"{port}: the board speaks version {heard.version} of the protocol, this hannes "
                f"version {VERSION}; update the older one"
            )
        if heard.lost:
            return heard.lost
        if not heard.bytes:
            return f"{port}: silence for {HELLO_TIME:g} s; is the board powered, and this its port?"
        return (
            f"{port}: {heard.bytes} bytes came, and no frame among them; wrong baud rate "
            f"(--baud) or another kind of board (--board)?"
        )


@contextmanager
def session(
    link: Link, log: str | Path, about: Mapping[str, Any] | None = None
) -> Iterator[Session]:
    """A Session that stops the board at its end, however that comes."""
    opened = Session(link, log, about)
    try:
        yield opened
    except BaseException as error:
        seen, interrupted = opened.close(), isinstance(error, KeyboardInterrupt)
        if (seen and interrupted) or (not seen and opened.moved):
            raise _ended(error, opened.stop_in_words()) from error
        raise
    opened.close()


def _ended(error: BaseException, words: str) -> HannesError:
    """What to say where something ended a session; `words`: what became of the stop."""
    if isinstance(error, KeyboardInterrupt):
        return Interrupted(f"interrupted; {words}")
    kind = ComputationFailed if isinstance(error, ComputationFailed) else HannesError
    return kind(f"{error}; {words}" if str(error) else words)
