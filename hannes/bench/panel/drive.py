"""What the page's buttons do to the board: set points towards a goal, or a profile, or a stop."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hannes.bench.events import Adapter, Event, Reply, Restarted, Row, Status
from hannes.bench.messages import Kind, Reason, State
from hannes.core.errors import BadInput

SILENCE = 0.5  # s without a word of the page, or a sample of the board, after which it is stopped
EVERY = 0.01  # s between set points
AGAIN = 0.05  # s between stops until the board obeys
PATIENCE = 3.0  # s within which a stop is answered, and a start moves the board
Knots = Sequence[tuple[float, float]]
MOVING = (State.RUNNING, State.FOLLOWING)


@dataclass(frozen=True)
class Range:
    """Angles of the output shaft [rad], hand open and closed; speed towards a goal [rad/s]."""

    opened: float = 0.0
    closed: float = 9.84
    speed: float = 15.4


class Drive:
    """Turns what the page asks for into bytes for the board; `send` hands them over.

    `profile_of`: corners of an experiment's command, None while they are still being checked;
    `limited`: what the grip policy makes of the command [rad], None where none limits it.
    `doing`: what is being done, in words, "" for nothing. `said`: why it was refused or ended.
    `set_point` [rad]: the last that was sent.
    """

    def __init__(
        self,
        speaker: Adapter,
        send: Callable[[bytes], None],
        profile_of: Callable[[str], Knots | None],
        within: Range,
        limited: Callable[[], float] | None = None,
    ) -> None:
        self._speaker, self._send, self._profile_of = speaker, send, profile_of
        self.within, self._limited = within, limited
        self.policy = limited is not None
        self.doing, self.said, self._asked = "", "", ""  # asked: an experiment, being checked
        self._command, self.set_point, self._goal = 0.0, 0.0, 0.0
        self._path: Knots = ()
        self._began, self._sent, self._heard = 0.0, -EVERY, 0.0
        self._position, self._state, self._place = 0.0, State.IDLE, -1
        self._sampled, self._says_state = 0.0, False
        self._stops, self._stopped, self._moved = 0, 0.0, False  # sent and not answered; when

    @property
    def is_moving(self) -> bool:
        """Whether the board was last seen to move; it is taken to where it says no state."""
        return self._state in MOVING if self._says_state else bool(self.doing)

    @property
    def wanted(self) -> float:
        """The command [rad] before any limit; where the hand is while nothing is asked for."""
        return self._command if self.doing else self._position

    def state(self, now: float) -> str:
        """State of the board at `now` [s] in words, as it was last seen."""
        if now - self._sampled > SILENCE:
            return "silent"
        return _words(self._state.name) if self._says_state else "says no state"

    def channels(self, names: Sequence[str]) -> None:
        """Note the board's channels."""
        self._place = names.index("position") if "position" in names else -1

    def see(self, event: Event, now: float) -> None:
        """Take what the board says at host time `now` [s]."""
        if isinstance(event, Row):
            self._sampled = now
            if self._place >= 0:
                self._position = event.values[self._place]
        elif isinstance(event, Restarted):
            self._began_anew()
        elif isinstance(event, Status):
            self._state, self._says_state = event.state, True
            if self.doing and not self._awaits_stop(now):
                self._judge(event.state, now)
        elif isinstance(event, Reply) and event.kind == Kind.STOP:
            self._stops = max(0, self._stops - 1)
        elif isinstance(event, Reply) and event.reason is not Reason.DONE and self.doing:
            self.stop(f"the board refused it: {_words(event.reason.name)}")

    def _began_anew(self) -> None:
        """A board that was reset has let the hand go, and awaits no answer."""
        self._state = State.IDLE
        if self.doing:
            self.stop("the board began anew: was it reset, or is its supply too weak?")
        self._stops = 0

    def _awaits_stop(self, now: float) -> bool:
        """Whether what the board says may still be of before the last stop."""
        return self._stops > 0 and now - self._stopped < PATIENCE

    def _judge(self, state: State, now: float) -> None:
        """End what is being done where the board has stopped moving, or never began."""
        if state in MOVING:
            self._moved = True
        elif self._moved:
            ended = state in (State.IDLE, State.STOPPED)
            self.stop("" if ended else f"the board stopped: {_words(state.name)}")
        elif now - self._began > PATIENCE:
            self.stop("the board did not move")

    def ask(self, message: Mapping[str, Any], now: float) -> None:
        """Take one message of the page, at host time `now` [s]; any of them counts as its word."""
        self._heard = now
        what, value = message.get("do"), message.get("value")
        if what not in ("beat", "policy"):
            self._asked = ""
        if what == "stop":
            self.stop("")
        elif what == "close":
            self._towards(self.within.closed, "closing", now)
        elif what == "open":
            self._towards(self.within.opened, "opening", now)
        elif what == "reference":
            self._refer(value, now)
        elif what == "experiment":
            self.stop("") if self.doing else None
            self._run(value if isinstance(value, str) else "", now)
        elif what == "policy":
            self.policy = value is True and self._limited is not None
        elif what != "beat":
            self.said = "the page asked for something unknown"

    def stop(self, why: str) -> None:
        """Open the drive, now; `why` is shown on the page."""
        self._send(self._speaker.stop())
        self._stops, self._stopped = self._stops + 1, self._heard
        self.doing, self.said, self._path = "", why, ()

    def go_on(self, now: float) -> None:
        """Send the set point that is due; stop where the page has been silent for too long."""
        if not self.doing:
            self._repeat_stop(now)
        if self._asked and now - self._heard <= SILENCE:
            self._run(self._asked, now)
        if not self.doing:
            return
        if now - self._heard > SILENCE:
            self.stop("stopped: the page was silent")
        elif now - max(self._sampled, self._began) > SILENCE:
            self.stop("stopped: the board was silent; look at its cable and supply")
        elif self._path and now - self._began > self._path[-1][0]:
            self.stop("")
        elif self.doing != "profile" and now - self._sent >= EVERY:
            self._command = self._next(now)
            self._sent = now
            self.set_point = self._below_limit()
            self._send(self._speaker.set_point(self.set_point))

    def _repeat_stop(self, now: float) -> None:
        """Send the stop again while the board still moves: a frame can be lost."""
        if self._stops and self._state in MOVING and now - self._sent >= AGAIN:
            self._sent = now
            self._send(self._speaker.stop())

    def _below_limit(self) -> float:
        """The command as far as the grip policy allows; its end makes no jump."""
        limited = self._limited() if self._limited and self.policy else self._command
        if not self._path:
            limited = min(limited, self.set_point + 2.0 * EVERY * self.within.speed)
        return min(limited, self._command)

    def _next(self, now: float) -> float:
        """The set point at `now`: on the path of an experiment, or a step nearer to the goal."""
        if self._path:
            import numpy as np

            times, values = np.array(self._path).T
            return float(np.interp(now - self._began, times, values))
        most = self.within.speed * min(max(now - self._sent, 0.0), 2.0 * EVERY)
        return min(max(self._goal, self._command - most), self._command + most)

    def _towards(self, goal: float, doing: str, now: float) -> None:
        if self.doing in ("profile", "experiment"):
            self.stop("")
        if not self.doing:
            self._command = self.set_point = self._position
            self._sent, self._began, self._moved = now, now, False
        self._goal, self.doing, self.said, self._path = goal, doing, "", ()

    def _refer(self, value: Any, now: float) -> None:
        low, high = self.within.opened, self.within.closed
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not low <= value <= high:
            self.said = f"expected a reference from {low:g} to {high:g} rad"
        else:
            self._towards(float(value), "reference", now)

    def _run(self, name: str, now: float) -> None:
        """Send an experiment's command whole; follow it under a policy, or without profiles."""
        try:
            points = self._profile_of(name)
        except BadInput as error:
            self.said, self._asked = str(error), ""
            return
        if points is None:
            self._asked, self.said = name, f"simulating {name} first, against the limits"
            return
        self._began, self.said, self._moved, self._asked = now, "", False, ""
        packets = [] if self.policy else self._speaker.profile(list(points))
        if packets:
            for packet in [*packets, self._speaker.start()]:
                self._send(packet)
            self.doing, self._path = "profile", ()
        else:
            self.doing, self._path, self._sent = "experiment", points, now - EVERY


def _words(name: str) -> str:
    return name.lower().replace("_", " ")
