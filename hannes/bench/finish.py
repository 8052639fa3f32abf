"""From a raw log to a recording: one row a frame, the board's clock, gaps kept as gaps.

Time is the board's, from the start of the profile (or the first sample where there was none).
Every frame counts once; one that never came is a gap, which nothing fills. The map
from the board's clock to the host's, and the gaps, stand in the recording's `conversion`.
"""

import json
import math
from array import array
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hannes.bench import haptics
from hannes.bench.adapters import adapter
from hannes.bench.clock_map import ClockMap, clock_map
from hannes.bench.events import About, Adapter, Event, Restarted, Row
from hannes.bench.onset import Onset
from hannes.bench.raw_log import EVENT, FROM_BOARD, HAPTIC, RawLogReader, Record
from hannes.bench.reader import NANO
from hannes.core.errors import BadInput
from hannes.core.io.bounded import deadline
from hannes.core.io.limits import table_fits
from hannes.core.recording.recording import Recording

PIECE = 1 << 16  # bytes of a record that an adapter is given at once
GAP = 1.5  # periods between two samples beyond which something is missing


@dataclass(frozen=True)
class Rows:
    """What a raw log holds: board times [s] (n,), host times [s] (n,), values (n, channels).

    haptics: commands of a tactor, with the board time [s] of the sample that they rest on; see
    `haptics.pack`. `start` is the board time [s] at which the last command began, None without one.
    left_out: where the log is cut off or damaged, and how much is left out, in words.
    """

    about: About
    board: np.ndarray
    host: np.ndarray
    values: np.ndarray
    start: float | None
    damaged: int
    events: tuple[tuple[float, str], ...]
    log: dict[str, Any]
    haptics: tuple[tuple[float, ...], ...] = ()
    left_out: str = ""

    def clock(self) -> ClockMap:
        """The map from board to host time."""
        return clock_map(self.board, self.host)


class _Samples:
    """Samples as they come, as plain numbers: Python's own objects take ten times as much."""

    def __init__(self, path: str | Path, size: int) -> None:
        self.path, self.size = path, size
        self.board, self.host, self.values = array("d"), array("d"), array("d")
        self.width = -1

    def add(self, row: Row, host: float) -> None:
        """Add a sample and the host's time [s]; BadInput where it fits no table."""
        if self.width not in (-1, len(row.values)):
            raise BadInput(
                f"{self.path}: samples of {self.width} and of {len(row.values)} channels; the "
                "board was changed while it was recorded"
            )
        self.width = len(row.values)
        self.board.append(row.time)
        self.host.append(host)
        self.values.extend(row.values)
        if not table_fits(len(self.board), self.width + 2, self.size):
            raise BadInput(f"{self.path}: {len(self.board)} samples are too many; cut the log")

    def in_order(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Board times, host times, values by board time, each time once.

        Frames that were sent again come late: by board time they are in their place.
        """
        board, host = np.frombuffer(self.board), np.frombuffer(self.host)
        values = np.frombuffer(self.values).reshape(board.size, self.width)
        order = np.argsort(board, kind="stable")
        order = order[np.append(True, np.diff(board[order]) > 0.0)]
        return board[order], host[order], values[order]


@dataclass
class _Life:
    """What came from a board between two resets; `start`: of its last command, None without."""

    samples: _Samples
    haptics: list[tuple[float, ...]] = field(default_factory=list)
    start: float | None = None


def read_rows(path: str | Path) -> Rows:
    """Read a raw log, whole, cut off, or up to a damage. Raises BadInput where no sample is in it.

    Where the board began anew, that part counts in which the last command began.
    """
    with closing(RawLogReader(path)) as log:
        return _rows(path, log)


def _rows(path: str | Path, log: RawLogReader) -> Rows:
    late = deadline(path)
    listener = _listener(path, log.about)
    life = kept = _Life(_Samples(path, log.size))
    about, events, onset = None, [], Onset()
    for record in log.records():
        late()
        if record.direction == EVENT:
            events.append((record.time * NANO, record.data.decode(errors="replace")))
        if record.direction == HAPTIC and (sent := haptics.unpack(record.data)):
            life.haptics.append(sent)
        if record.direction != FROM_BOARD:
            continue
        for event in _heard(listener, record, late):
            if isinstance(event, Row):
                life.samples.add(event, record.time * NANO)
            elif isinstance(event, About):
                about = event
            elif isinstance(event, Restarted):
                kept, life = _newer(kept, life), _Life(_Samples(path, log.size))
                events.append((record.time * NANO, "the board began anew"))
            if (began := onset.feed(event)) is not None:
                life.start = began
    life = _newer(kept, life)
    samples = life.samples
    if about is None or not samples.board:
        raise BadInput(f"{path}: no sample came from the board; nothing to recover")
    if len(about.channels) != samples.width:
        raise BadInput(f"{path}: the board named {len(about.channels)} channels and sent others")
    board, host, values = samples.in_order()
    said = (tuple(events), log.about, tuple(life.haptics), log.left_out())
    return Rows(about, board, host, values, life.start, listener.damaged, *said)


def _newer(before: _Life, life: _Life) -> _Life:
    """The one that counts: the newer, unless it has no samples, or only the other has a command."""
    if not life.samples.board or (life.start is None and before.start is not None):
        return before
    return life


def _heard(listener: Adapter, record: Record, late: Callable[[], None]) -> Iterator[Event]:
    """What a record says, piece by piece."""
    for at in range(0, len(record.data), PIECE):
        yield from listener.feed(record.data[at : at + PIECE], record.time * NANO)
        late()


def _listener(path: str | Path, about: dict[str, Any]) -> Adapter:
    """The adapter that a log's first line names."""
    name, options = about.get("board", "hannes"), about.get("options", {})
    if not isinstance(name, str) or not isinstance(options, dict):
        raise BadInput(f"{path}: its first line names no board; the log is damaged there")
    try:
        return adapter(name, **options)
    except (TypeError, ValueError, AttributeError, ArithmeticError):
        raise BadInput(f"{path}: its first line has other options than the board {name}") from None


def _notes(given: Any) -> list[str]:
    """Notes of a raw log's first line; what is no text is none."""
    return [each for each in given if isinstance(each, str)] if isinstance(given, list) else []


def gaps(time: np.ndarray, period: float) -> list[tuple[float, float]]:
    """Intervals [s] between samples that are further apart than GAP periods."""
    far = np.flatnonzero(np.diff(time) > GAP * period)
    return [(float(time[k]), float(time[k + 1])) for k in far]


def recording(
    rows: Rows,
    *,
    duration: float | None = None,
    experiment: str = "",
    plant: str = "",
    hand: str = "",
) -> Recording:
    """Return the recording of `rows`: from the profile's start on, for `duration` [s] or all.

    Raises BadInput where fewer than two samples are left.
    """
    start = rows.start if rows.start is not None else float(rows.board[0])
    time = rows.board - start
    inside = time >= -1e-9
    if duration is not None:
        inside &= time <= duration + 1e-9
    if np.count_nonzero(inside) < 2:
        raise BadInput("fewer than two samples came after the start; nothing to write")
    time = np.round(time[inside], 9)
    rate = rows.about.rate
    period = 1.0 / rate if 0.0 < rate < math.inf else float(np.median(np.diff(time)))
    clock = rows.clock()
    said = {
        "from": "raw log of a board",
        "firmware": rows.about.firmware,
        "clock": {"offset_s": clock.offset, "drift": clock.drift},
        "gaps_s": gaps(time, period),
        "damaged_frames": rows.damaged,
        "notes": _notes(rows.log.get("notes")),
        "events": [words for _, words in rows.events],
        "left_out": rows.left_out,
    }
    channels = {"time": time}
    units = {"time": "s"}
    for k, (name, unit) in enumerate(rows.about.channels.items()):
        channels[name], units[name] = rows.values[inside, k], unit
    for name, (unit, values) in haptics.channels(rows.haptics, rows.board[inside]).items():
        channels[name], units[name] = values, unit
    return Recording(
        channels,
        units,
        plant=plant,
        experiment=experiment,
        hand=hand,
        source="measured",
        conversion=json.dumps(said, sort_keys=True),
    )
