"""From a raw log to a recording: one row a frame, the board's clock, gaps kept as gaps.

Time is the board's, from the start of the profile (or the first sample where there was none).
Every frame counts once; one that never came is a gap, which nothing fills. The map
from the board's clock to the host's, and the gaps, stand in the recording's `conversion`.
"""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hannes.bench import haptics
from hannes.bench.adapters import adapter
from hannes.bench.clock_map import ClockMap, clock_map
from hannes.bench.events import About, Adapter, Row
from hannes.bench.onset import Onset
from hannes.bench.raw_log import EVENT, FROM_BOARD, HAPTIC, RawLogReader
from hannes.bench.reader import NANO
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording

GAP = 1.5  # periods between two samples beyond which something is missing


@dataclass(frozen=True)
class Rows:
    """What a raw log holds: board times [s] (n,), host times [s] (n,), values (n, channels).

    haptics: commands of a tactor, with the board time [s] of the sample that they rest on; see
    `haptics.pack`. `start` is the board time [s] at which the last command began, None without one.
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

    def clock(self) -> ClockMap:
        """The map from board to host time."""
        return clock_map(self.board, self.host)


def read_rows(path: str | Path) -> Rows:
    """Read a raw log, whole or cut off. Raises BadInput where no sample is in it."""
    log = RawLogReader(path)
    listener = _listener(path, log.about)
    rows: list[tuple[Row, float]] = []
    about, start, events, onset = None, None, [], Onset()
    commands: list[tuple[float, ...]] = []
    for record in log.records():
        if record.direction == EVENT:
            events.append((record.time * NANO, record.data.decode(errors="replace")))
        if record.direction == HAPTIC and (sent := haptics.unpack(record.data)):
            commands.append(sent)
        if record.direction != FROM_BOARD:
            continue
        for event in listener.feed(record.data, record.time * NANO):
            if isinstance(event, Row):
                rows.append((event, record.time * NANO))
            elif isinstance(event, About):
                about = event
            elif (began := onset.feed(event)) is not None:
                start = began
    log.close()
    if about is None or not rows:
        raise BadInput(f"{path}: no sample came from the board; nothing to recover")
    made = _in_order(about, rows, start, listener, tuple(events), log.about)
    return replace(made, haptics=tuple(commands))


def _listener(path: str | Path, about: dict[str, Any]) -> Adapter:
    """The adapter that a log's first line names."""
    name, options = about.get("board", "hannes"), about.get("options", {})
    if not isinstance(name, str) or not isinstance(options, dict):
        raise BadInput(f"{path}: its first line names no board; the log is damaged there")
    try:
        return adapter(name, **options)
    except (TypeError, ValueError, AttributeError):
        raise BadInput(f"{path}: its first line has other options than the board {name}") from None


def _in_order(
    about: About,
    rows: list[tuple[Row, float]],
    start: float | None,
    listener: Adapter,
    events: tuple[tuple[float, str], ...],
    log: dict[str, Any],
) -> Rows:
    """Frames that were sent again come late: by board time they are in their place."""
    rows.sort(key=lambda pair: pair[0].time)
    board = np.array([row.time for row, _ in rows])
    new = np.append(True, np.diff(board) > 0.0)
    host = np.array([host for _, host in rows])
    values = np.array([row.values for row, _ in rows])
    return Rows(about, board[new], host[new], values[new], start, listener.damaged, events, log)


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
    period = 1.0 / rows.about.rate if rows.about.rate else float(np.median(np.diff(time)))
    clock = rows.clock()
    said = {
        "from": "raw log of a board",
        "firmware": rows.about.firmware,
        "clock": {"offset_s": clock.offset, "drift": clock.drift},
        "gaps_s": gaps(time, period),
        "damaged_frames": rows.damaged,
        "notes": rows.log.get("notes", []),
        "events": [words for _, words in rows.events],
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
