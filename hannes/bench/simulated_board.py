"""A board in simulated time: the same logic, frames and adapter, without a port or a clock."""

from collections.abc import Callable, Iterator

from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Machine, Settings
from hannes.bench.events import Event
from hannes.bench.frames import Splitter, encode
from hannes.bench.grip_loop import GripLoop, Said

STREAM = 5  # ticks between two set points, as a live link sends them
BEAT = 50  # ticks between two words to the watchdog


class SimulatedBoard:
    """A machine behind a board's rules; bytes go in and events come out, tick by tick."""

    def __init__(self, machine: Machine, settings: Settings | None = None) -> None:
        self.logic = BoardLogic(machine, settings or Settings())
        self.speaker, self._listener = Framed(), Framed()
        self._splitter = Splitter(HOST_LENGTHS)

    def send(self, data: bytes) -> list[Event]:
        """Give the board bytes; returns what it says at once."""
        frames = [a for frame in self._splitter.feed(data) for a in self.logic.hear(frame)]
        return self._heard(b"".join(map(encode, frames)))

    def tick(self) -> list[Event]:
        """Let one period pass."""
        return self._heard(b"".join(map(encode, self.logic.tick())))

    def _heard(self, data: bytes) -> list[Event]:
        return self._listener.feed(data, self.logic.time * 1e-6)


def grasped(
    board: SimulatedBoard, loop: GripLoop, command: Callable[[float], float], ticks: int
) -> Iterator[list[Said]]:
    """Close a simulated hand for `ticks` by `command` (time [s] to angle [rad]) through the loop.

    Gives what was said at each tick.
    """
    said = [loop.feed(event, 0.0) for event in board.send(board.speaker.ask())]
    for tick in range(ticks):
        wanted = command(tick / board.logic.settings.rate)
        events = []
        if tick % STREAM == 0:
            events += board.send(board.speaker.set_point(loop.set_point))
        if tick % BEAT == 0:
            events += board.send(board.speaker.alive(tick))
        events += board.tick()
        said += [loop.feed(event, wanted) for event in events]
        yield said
        said = []
