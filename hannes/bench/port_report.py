"""`hannes port PORT`: how good a link is: round trip, lost and damaged frames, what to change."""

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hannes.bench.events import About, Status
from hannes.bench.finish import read_rows
from hannes.bench.raw_log import TO_BOARD, RawLogReader
from hannes.bench.reader import NANO, Link
from hannes.bench.session import session

SLOW = 5e-3  # s of round trip beyond which a latency timer is likely at work


@dataclass(frozen=True)
class LinkReport:
    """Figures of a link over some seconds; times in s, rates in Hz."""

    about: About
    notes: tuple[str, ...]
    seconds: float
    round_trip: tuple[float, float, float] | None  # median, 99 %, longest
    rows: int
    lost: int
    damaged: int
    drift: float

    def advice(self) -> list[str]:
        """What to change, a line each."""
        lines = []
        if self.round_trip and self.round_trip[0] > SLOW:
            lines.append(
                "the round trip is long: set the adapter's latency timer to 1 ms "
                "(/sys/bus/usb-serial/devices/*/latency_timer), or avoid a hub"
            )
        if self.lost:
            lines.append("frames were lost: a higher baud rate, a shorter cable, fewer programs")
        if self.damaged:
            lines.append("frames came damaged: check baud rate, ground and shielding")
        if any("ordinary" in note for note in self.notes):
            lines.append("for real-time priority: run as root, or allow rtprio in limits.conf")
        return lines


def examine(link: Link, seconds: float = 3.0) -> LinkReport:
    """Talk to a board for a while and measure; BadInput where it cannot be reached."""
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "port.rawlog"
        with session(link, raw) as talk:
            about, notes = talk.hello(), tuple(talk.reader.notes)
            torn = min(talk.damaged, 1)  # the frame that was under way as the port was opened
            began = time.monotonic()
            talk.wait(lambda: False, seconds)
            seconds = time.monotonic() - began
            talk.close()
        rows = read_rows(raw)
        return LinkReport(
            about,
            notes,
            seconds,
            _round_trips(raw, link),
            rows.board.size,
            _lost(rows.board, about.rate),
            rows.damaged - torn,
            rows.clock().drift,
        )


def _lost(board: np.ndarray, rate: float) -> int:
    """Samples that never came, by the board's clock."""
    if not rate:
        return 0
    return max(round((board[-1] - board[0]) * rate) + 1 - board.size, 0)


def _round_trips(raw: Path, link: Link) -> tuple[float, float, float] | None:
    """Time from a beat sent to the status that answers it [s]: median, 99 %, longest.

    None of a board that says no status.
    """
    log, listener, speaker = RawLogReader(raw), link.adapter(), link.adapter()
    sent: list[float] = []
    trips: dict[int, float] = {}
    for record in log.records():
        if record.direction == TO_BOARD:
            if len(record.data) == len(speaker.alive(0)):  # no other word of a session is so long
                sent.append(record.time * NANO)
            continue
        for event in listener.feed(record.data, record.time * NANO):
            if isinstance(event, Status) and 0 < event.beat <= len(sent):
                trips.setdefault(event.beat, record.time * NANO - sent[event.beat - 1])
    log.close()
    if not trips:
        return None
    values = np.array(list(trips.values()))
    return float(np.median(values)), float(np.quantile(values, 0.99)), float(values.max())
