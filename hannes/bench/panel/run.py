"""`hannes panel PORT`: the board, the model beside it and the page, until Ctrl-C."""

import contextlib
import math
import queue
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from hannes.bench.board_logic import Limits
from hannes.bench.panel.drive import Drive, Knots, Range
from hannes.bench.panel.page import panel_page
from hannes.bench.panel.server import PanelServer
from hannes.bench.panel.traces import Traces
from hannes.bench.profile_check import require_within
from hannes.bench.reader import Link
from hannes.bench.record import command_points
from hannes.bench.session import Session, session
from hannes.core.errors import BadInput, ComputationFailed
from hannes.recognition.known_hand import unknown_hand
from hannes.recognition.model import Model
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.variants import Variant

POLL = 0.004  # s
AT_ONCE = 5  # events between two looks at what the page asks
Progress = Callable[[str], None]
BEGINS = ("close", "experiment")  # with these a new grasp begins


@dataclass(frozen=True)
class Panel:
    """What a panel shows: `beside` steps as the model, `model` recognises, `port` 0: any.

    raw: where the bytes are kept as they came, None for nowhere; policy: whether it begins with the
    grip limited, which needs a model; hand: numbers of its empty closure, None: not known.
    """

    link: Link
    beside: Variant
    model: Model | None = None
    port: int = 0
    raw: Path | None = None
    policy: bool = True
    hand: np.ndarray | None = None


def run_panel(panel: Panel, say: Progress, until: Callable[[], bool] = lambda: False) -> None:
    """Serve the panel until `until` says so; `say` is given its address, and notes.

    Ctrl-C is its usual end. Raises BadInput where board or address cannot be had, ComputationFailed
    where the link is lost, or the hand moved and was not seen to stop. Whatever ends it, the board
    is stopped.
    """
    traces = Traces(panel.beside.hand, panel.beside.experiment, panel.model, panel.hand)
    within = Range(closed=_closed(panel.beside))
    about = {} if panel.hand is None else {"empty_closure": panel.hand.tolist()}
    with _raw(panel.raw) as raw, Profiles() as profiles, session(panel.link, raw, about) as talk:
        board = talk.hello()
        limited = (lambda: traces.set_point) if panel.model else None
        drive = Drive(talk.speaker, talk.reader.send, profiles, within, limited)
        drive.policy = panel.policy and limited is not None
        drive.channels(list(board.channels))
        traces.see(board, False, 0.0, 0.0)
        notice = unknown_hand(panel.model) if panel.model and panel.hand is None else ""
        recognises = panel.model is not None
        page = panel_page(panel.link.port, _experiments(), within, recognises, notice)
        with PanelServer(page, lambda: _state(talk, drive, traces), panel.port) as server:
            say(f"{panel.link.port}: {board.firmware}, {len(board.channels)} channels")
            if notice:
                say(notice)
            say(f"open {server.address}")
            with contextlib.suppress(KeyboardInterrupt):
                _loop(talk, drive, traces, server, until)
        if not talk.close() and talk.moved:
            raise ComputationFailed("the panel has ended")  # its session says of the stop
        say(f"the panel has ended; {talk.stop_in_words()}")


def _loop(
    talk: Session, drive: Drive, traces: Traces, server: PanelServer, until: Callable[[], bool]
) -> None:
    while not until():
        for count, event in enumerate(talk.events()):
            drive.see(event, time.monotonic())
            traces.see(event, drive.is_moving, drive.wanted, drive.set_point)
            if count % AT_ONCE == 0:
                _attend(drive, traces, server)
        _attend(drive, traces, server)
        if not talk.reader.is_alive():
            raise ComputationFailed(talk.heard.lost or f"{talk.link.port}: the link was lost")
        time.sleep(POLL)


def _attend(drive: Drive, traces: Traces, server: PanelServer) -> None:
    """Do what the page has asked for, and what is due."""
    with contextlib.suppress(queue.Empty):
        while True:
            asked = server.asked.get_nowait()
            if asked.get("do") in BEGINS and not drive.doing:
                traces.begin()
            drive.ask(asked, time.monotonic())
    drive.go_on(time.monotonic())


def _state(talk: Session, drive: Drive, traces: Traces) -> dict[str, Any]:
    """What the page is sent each time."""
    return {
        "board": drive.state(time.monotonic()),
        "policy": drive.policy,
        "doing": drive.doing,
        "said": drive.said,
        "samples": talk.heard.rows,
        **traces.take(),
    }


def _closed(beside: Variant) -> float:
    """The furthest reference of the experiment [rad], whole hundredths."""
    most = max(float(each) for each in beside.experiment.reference.knots[1])
    return math.floor(100.0 * most + 1e-6) / 100.0 if most > 0.0 else Range().closed


def _experiments() -> list[str]:
    """Shipped experiments of one run."""
    found = []
    for name in shipped.names():
        with contextlib.suppress(BadInput):  # one that needs no simulation
            found += [name] if len(load_experiment(name)) == 1 else []
    return found


class Profiles:
    """Corners of the shipped experiments' references, each simulated first against the limits.

    The simulation runs beside the panel, which goes on; until it ends, a call gives None. Raises
    BadInput for what is none, or breaks the limits.
    """

    def __init__(self, limits: Limits | None = None) -> None:
        self._pool, self._limits = ThreadPoolExecutor(1), limits
        self._checks: dict[str, Future[Knots]] = {}

    def __call__(self, name: str) -> Knots | None:
        """Corners of the experiment `name`: (time [s], angle [rad])."""
        if name not in shipped.names():
            raise BadInput(f'no experiment "{name:.60}"')
        if name not in self._checks:
            self._checks[name] = self._pool.submit(self._checked, name)
        return self._checks[name].result() if self._checks[name].done() else None

    def _checked(self, name: str) -> Knots:
        variant = load_experiment(name)[0]
        try:
            require_within(variant.hand, variant.experiment, self._limits)
        except ComputationFailed as error:
            raise BadInput(f"{name}: {error}") from None
        return command_points(variant.experiment)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)


@contextlib.contextmanager
def _raw(path: Path | None) -> Iterator[Path]:
    """Where the reader writes: as asked, or a folder that goes with the panel."""
    if path is not None:
        if path.exists():
            raise BadInput(f"{path}: is there already; a raw log is never written over")
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder) / "panel.rawlog"
