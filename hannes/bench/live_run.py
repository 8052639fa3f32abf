"""A live grasp: a board followed, and closed by a command under the grip policy, as it happens.

    for moment in live(link, model, log, LiveOrder(experiment)):
        print(moment.decision.word, moment.force)

However the iteration ends (its last moment, an exception, Ctrl-C, a lost link), the board is sent a
stop, and the stop is looked for in its telemetry. `replayed` gives the same decisions, forces and
haptic commands from the raw log, bit for bit: they follow from the board's bytes alone.
"""

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes.bench import haptics
from hannes.bench.adapters import adapter
from hannes.bench.events import Event, Row
from hannes.bench.grip_loop import Force, GripLoop, GripPlan, Observer
from hannes.bench.haptics import HapticCommand
from hannes.bench.live import Decision, warm_up
from hannes.bench.port import now
from hannes.bench.profile_check import require_within
from hannes.bench.raw_log import FROM_BOARD, HAPTIC, RawLogReader
from hannes.bench.reader import NANO, Link
from hannes.bench.record import STREAM
from hannes.bench.session import Session, session
from hannes.core.errors import BadInput, ComputationFailed
from hannes.recognition.known_hand import checked, unknown_hand
from hannes.recognition.model import Model
from hannes.simulation.experiment.variants import Variant
from hannes.simulation.experiment.writer import experiment_toml
from hannes.simulation.hand.hand_file import hand_toml

LOOK = 0.001  # s between two looks at the raw log
BEHIND = 1.0  # s by which decisions may be behind the board
AHEAD = 0.1  # s by which the command may be ahead of them: it waits for what limits it


@dataclass(frozen=True)
class LiveOrder:
    """What a live grasp is to do: the experiment whose command closes the hand, None to watch.

    seconds: how long to go on, 0 for the experiment's duration, or without end; observer: makes
    what estimates the force; tactor: is handed every haptic command; progress: takes what happens
    in words; hand: numbers of its empty closure (known_hand.py), None for one that is not known.
    """

    variant: Variant | None = None
    plan: GripPlan = field(default_factory=GripPlan)
    seconds: float = 0.0
    observer: Callable[[], Observer] | None = None
    tactor: Callable[[HapticCommand], None] | None = None
    progress: Callable[[str], None] = lambda text: None
    hand: np.ndarray | None = None


@dataclass(frozen=True)
class Moment:
    """What is known when a decision or a haptic command was made.

    time: of the newest sample on the board's clock [s]; values: its channels by name; firm: whether
    the policy holds firmly; set_point [rad]; released: what was held is let go; damaged, gaps:
    frames that failed their checks, and intervals that never came, so far (of the link, so that a
    replay need not repeat them)
    """

    time: float
    values: dict[str, float]
    decision: Decision | None
    force: Force | None
    haptic: HapticCommand | None
    firm: bool
    set_point: float
    released: bool = False
    damaged: int = field(default=0, compare=False)
    gaps: int = field(default=0, compare=False)


class _Following:
    """Feeds events to the loop, and gathers moments."""

    def __init__(self, loop: GripLoop, wanted: float = 0.0) -> None:
        self.loop, self.wanted = loop, wanted
        self.moments: deque[Moment] = deque()
        self.heard, self.time = time.monotonic(), 0.0  # of the last row: host and board [s]
        self._decision: Decision | None = None
        self._force: Force | None = None
        self._names: tuple[str, ...] = ()

    def feed(self, event: Event) -> None:
        """Take one event."""
        if isinstance(event, Row):
            self.heard, self.time = time.monotonic(), event.time
        said = self.loop.feed(event, self.wanted)
        self._force = said.force or self._force
        self._decision = said.decisions[-1] if said.decisions else self._decision
        if isinstance(event, Row) and (said.decisions or said.haptic):
            values = dict(zip(self.loop.channels, event.values, strict=False))
            self.moments.append(Moment(
                event.time, values, said.decisions[-1] if said.decisions else None, self._force,
                said.haptic, self.loop.firm, self.loop.set_point, said.released,
            ))  # fmt: skip


def live(link: Link, model: Model, log: str | Path, order: LiveOrder) -> Generator[Moment]:
    """Follow a board, and close the hand where the order has a command; gives moments as they come.

    The raw log is written to `log`. Raises BadInput where the board cannot be reached or the
    command breaks limits in simulation, ComputationFailed where the board stops by itself, the link
    is lost, or the stop at the end was not seen.
    """
    about: dict[str, object] = {}
    if order.variant is not None:
        experiment = order.variant.experiment
        require_within(order.variant.hand, experiment, progress=order.progress)
        about = {"experiment": experiment_toml(order.variant.hand, experiment),
                 "hand": hand_toml(order.variant.hand)}  # fmt: skip
    if order.hand is not None:
        about["empty_closure"] = order.hand.tolist()
    elif notice := unknown_hand(model):
        order.progress(notice)
    warm_up(model)
    observer = order.observer() if order.observer else None
    command, _ = _command(order)
    loop = GripLoop(model, order.plan, observer, order.hand)
    following = _Following(loop, command(0.0) if command else 0.0)
    with session(link, log, about) as talk:
        talk.watch = following.feed
        board = talk.hello()
        order.progress(f"{link.port}: {board.firmware}, {board.rate:g} Hz")
        for note in talk.reader.notes:
            order.progress(note)
        yield from _moments(talk, following, order)
        if not talk.close():
            raise ComputationFailed(talk.stop_in_words())


def _moments(talk: Session, following: _Following, order: LiveOrder) -> Iterator[Moment]:
    command, seconds = _command(order)
    began, sent, unread = time.monotonic(), -STREAM, talk.events()
    since, first = 0.0, following.time
    try:
        while not seconds or since < seconds:
            since = min(time.monotonic() - began, following.time - first + AHEAD)
            following.wanted = command(since) if command else 0.0
            unread = _read_some(talk, unread)
            talk.require_following()
            _require_pace(talk)
            _require_rows(talk, following)
            yield from _passed_on(talk, following, order)
            if command and following.loop.begun and since - sent >= STREAM:
                talk.reader.send(talk.speaker.set_point(following.loop.set_point))
                sent = since
    finally:
        if order.tactor:
            order.tactor(HapticCommand(0.0, 0.0, 0.0))


def _read_some(talk: Session, unread: Iterator[Event]) -> Iterator[Event]:
    """Read for at most a STREAM, so that set points go out on time; returns what is left."""
    until = time.monotonic() + STREAM
    while time.monotonic() < until:
        if next(unread, None) is None:
            time.sleep(LOOK)
            return talk.events()
    return unread


def _require_rows(talk: Session, following: _Following) -> None:
    """Raise ComputationFailed where the board has gone silent: nobody sees the hand then."""
    silent = time.monotonic() - following.heard
    if silent > BEHIND:
        raise ComputationFailed(
            f"{talk.link.port}: the board has sent nothing for {silent:.1f} s, so the grasp was "
            "ended; look at its cable and supply"
        )


def _require_pace(talk: Session) -> None:
    """Raise ComputationFailed where decisions rest on what came too long ago."""
    behind = (now() - talk.read_up_to) * NANO
    if talk.read_up_to and behind > BEHIND:
        raise ComputationFailed(
            f"{talk.link.port}: recognition is {behind:.1f} s behind the board, so the grasp was "
            "ended; end other programs, or leave out the force observer"
        )


def _command(order: LiveOrder) -> tuple[Callable[[float], float] | None, float]:
    """Angle [rad] by time [s], and how long to go on [s]."""
    if order.variant is None:
        return None, order.seconds
    experiment = order.variant.experiment
    times, angles = experiment.reference.knots
    return (lambda since: float(np.interp(since, times, angles))), (
        order.seconds or experiment.duration
    )


def _passed_on(talk: Session, following: _Following, order: LiveOrder) -> Iterator[Moment]:
    while following.moments:
        moment = following.moments.popleft()
        if moment.haptic is not None:
            talk.reader.write_down(HAPTIC, haptics.pack(moment.time, moment.haptic))
            if order.tactor:
                order.tactor(moment.haptic)
        yield replace(moment, damaged=talk.damaged, gaps=talk.gaps)


def known_by(about: Mapping[str, Any], model: Model) -> np.ndarray | None:
    """Numbers of the hand's empty closure that a raw log keeps; BadInput where they are none."""
    given = about.get("empty_closure")
    if given is None:
        return None
    if not isinstance(given, list) or not all(type(each) in (int, float) for each in given):
        raise BadInput("the raw log's empty_closure: expected numbers")
    try:
        numbers = np.array(given, float)
    except OverflowError:
        raise BadInput("the raw log's empty_closure: expected numbers of usual size") from None
    return checked(numbers, model)


def replayed(
    log: str | Path, model: Model, plan: GripPlan | None = None, observer: Observer | None = None
) -> Iterator[Moment]:
    """The moments of a raw log: decisions, forces and haptic commands are those that were live."""
    records = RawLogReader(log)
    listener = adapter(records.about.get("board", "hannes"), **records.about.get("options", {}))
    following = _Following(GripLoop(model, plan, observer, known_by(records.about, model)))
    for record in records.records():
        if record.direction == FROM_BOARD:
            for event in listener.feed(record.data, record.time * NANO):
                following.feed(event)
        while following.moments:
            yield following.moments.popleft()
    records.close()
