"""Recognition while the hand closes: the same decisions live and afterwards, bit for bit.

Samples enter in the order of the raw log. What is said at a moment follows from samples up to it
alone; a gap is bridged by a straight line once the next sample is there, as for a recording.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hannes.bench.adapters import adapter
from hannes.bench.events import About, Event, Row
from hannes.bench.onset import Onset
from hannes.bench.raw_log import FROM_BOARD, RawLogReader
from hannes.bench.reader import NANO
from hannes.core.errors import BadInput
from hannes.recognition.features import CHANNELS, NAMES
from hannes.recognition.model import (
    SINCE,
    WORDS,
    Estimate,
    Model,
    decided,
    grasp_peak,
    grasp_stiffness,
    held,
    running,
)

TOUCH = NAMES.index("touch_position")
LONGEST = 30.0  # s of one grasp; then a new one is taken to begin


@dataclass(frozen=True)
class Decision:
    """What is said at the end of one window; times in s since the grasp's start.

    board_time: of the newest sample that it rests on [s]; word: soft, rigid or don't know; rigid:
    probability; touched: whether a contact was detected, and the shaft's position there [rad];
    stiffness [N/m] and most force so far [N], with 95 % intervals, while something is held.
    """

    time: float
    board_time: float
    word: str
    rigid: float
    touched: bool
    touch_position: float
    held: bool
    stiffness: Estimate | None
    force: Estimate | None


def channel_places(about: About) -> list[int]:
    """Places of current, position, reference in a board's rows; BadInput where one is missing."""
    names = list(about.channels)
    for name in CHANNELS:
        if name not in names:
            raise BadInput(f'the board sends no channel "{name}"; recognition needs it')
    return [names.index(name) for name in CHANNELS]


class LiveRecogniser:
    """Takes events of a board, gives decisions. Raises BadInput where a channel is missing."""

    def __init__(self, model: Model) -> None:
        self.model, self._onset = model, Onset()
        self._places: list[int] | None = None
        self._begin(0.0)

    def feed(self, event: Event) -> list[Decision]:
        """Take one event; return the decisions that it allows, often none."""
        if isinstance(event, Row) and self._places is not None:
            return self._sample(event)
        if isinstance(event, About):
            self._places = channel_places(event)
        elif (began := self._onset.feed(event)) is not None:
            self._begin(began)
        return []

    def _begin(self, board_time: float) -> None:
        self._start, self._times, self._rows = board_time, list[float](), list[list[float]]()
        self._grid = np.empty((1024, len(CHANNELS)))
        self._count = self._windows = 0
        self._known = _Windows.none()

    def _sample(self, row: Row) -> list[Decision]:
        since = row.time - self._start
        if since < -1e-9 or (self._times and since <= self._times[-1]):
            return []  # before the start, or a frame sent again: too late for live
        if since > LONGEST:
            self._begin(row.time)
            since = 0.0
        self._times.append(since)
        self._rows.append([row.values[k] for k in self._places or ()])
        self._extend()
        return self._decide(row.time)

    def _extend(self) -> None:
        """Bring the newest samples onto the model's grid."""
        sampling, first = self.model.windowing.sampling, self._times[0]
        last = int((self._times[-1] - first) * sampling + 1e-6)
        near, rows = np.array(self._times[-2:]) - first, np.array(self._rows[-2:])
        for k in range(self._count, last + 1):
            if k == len(self._grid):
                self._grid = np.concatenate([self._grid, np.empty_like(self._grid)])
            self._grid[k] = [np.interp(k / sampling, near, column) for column in rows.T]
        self._count = max(self._count, last + 1)

    def _decide(self, board_time: float) -> list[Decision]:
        ends = self.model.windowing.ends(self._count)
        if ends.size <= self._windows:
            return []
        rows = self.model.windowing.features(self._grid[np.newaxis, : self._count])[0]
        made = []
        for k in range(self._windows, ends.size):
            self._known.add(self.model, rows[k : k + 1])
            made.append(self._decision(rows[: k + 1], board_time))
        self._windows = ends.size
        return made

    def _decision(self, rows: np.ndarray, board_time: float) -> Decision:
        model, touched, holds = self.model, rows[:, SINCE] > 0.0, held(rows)
        so_far = running(np.array(self._known.rigid), touched, model.windowing.hop)
        probability = float(so_far[-1]) if holds.any() else 0.5
        word = WORDS[int(decided(np.array([probability]), model.sure)[0])]
        stiffness = force = None
        if holds.any():
            value, apart = grasp_stiffness(np.array(self._known.stiffness)[holds])
            stiffness = Estimate(value, *model.stiffness_band(value, apart))
        if holds[-1]:
            value, apart = grasp_peak(model.force.quantiles(rows[-1:])[0])
            force = Estimate(value, *model.force_band(value, apart))
        time = float(model.windowing.times(self._count)[len(rows) - 1])
        return Decision(
            time, board_time, word, probability, bool(touched[-1]), float(rows[-1, TOUCH]),
            bool(holds[-1]), stiffness, force,
        )  # fmt: skip


@dataclass
class _Windows:
    """What the forests say of each window so far: probability of rigid, quantiles of stiffness."""

    rigid: list[float]
    stiffness: list[np.ndarray]

    @staticmethod
    def none() -> "_Windows":
        return _Windows([], [])

    def add(self, model: Model, row: np.ndarray) -> None:
        """Take in the features of one more window, shape (1, features)."""
        self.rigid.append(float(model.windows(row)[0]))
        self.stiffness.append(model.stiffness.quantiles(row)[0])


class Follower:
    """Reads a raw log as it grows and recognises: `for decision in Follower(log, model): ...`

    `poll` gives what is there; iterating goes through a log that is whole.
    """

    def __init__(self, log: str | Path, model: Model) -> None:
        self._log = RawLogReader(log)
        about = self._log.about
        self._listener = adapter(about.get("board", "hannes"), **about.get("options", {}))
        self._live = LiveRecogniser(model)

    def poll(self) -> Iterator[tuple[Event, list[Decision]]]:
        """Events that have come since the last look, each with the decisions that it allows."""
        for record in self._log.records():
            if record.direction == FROM_BOARD:
                for event in self._listener.feed(record.data, record.time * NANO):
                    yield event, self._live.feed(event)

    def __iter__(self) -> Iterator[Decision]:
        for _, decisions in self.poll():
            yield from decisions

    def close(self) -> None:
        """Close the log."""
        self._log.close()
