"""When a grasp begins: at the start of a profile, or at the first of a run of set points."""

from hannes.bench.events import Event, Reply, Restarted, Status
from hannes.bench.messages import Kind, Reason, State


class Onset:
    """Watches events; `feed` gives the board time [s] of one at which a command begins."""

    def __init__(self) -> None:
        self._following = False

    def feed(self, event: Event) -> float | None:
        """Take one event."""
        if isinstance(event, Status):
            self._following &= event.state is State.FOLLOWING
        if isinstance(event, Restarted):
            self._following = False
        if not isinstance(event, Reply) or event.reason is not Reason.DONE:
            return None
        first = event.kind == Kind.SET_POINT and not self._following
        self._following |= event.kind == Kind.SET_POINT
        return event.time if event.kind == Kind.START or first else None
