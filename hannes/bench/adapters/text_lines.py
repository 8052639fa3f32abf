"""Boards that print lines: numbers in columns, or `name:value` pairs, as the Arduino plotter reads.

    # time_us position_rad current_A        a header (a comment or not) names columns and units
    1000 0.1234 0.056
    time_us:2000 position_rad:0.1240 current_A:0.061

Commands to the board are lines too: `r 1.234` (reference [rad]), `s` (stop), `?` (header, please).
"""

import math
import re

from hannes.bench.events import About, Event, Row

LONGEST = 1024  # characters of a line
PAIR = re.compile(r"([A-Za-z]\w*)\s*[:=]\s*([-+0-9.eE]+)")
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6}


class TextLines:
    """Adapter for lines of numbers. Without a time column the host's clock is taken."""

    name = "text"
    baud = 115_200
    polls = 0.0

    def __init__(self, columns: str = "") -> None:
        self._columns = _names(columns)
        self._rest, self._number, self._damaged = b"", 0, 0
        self._said = False

    def ask(self) -> bytes:
        """Ask for the header."""
        return b"?\n"

    def alive(self, beat: int) -> bytes:
        """A comment: boards that have a watchdog may take it."""
        return b"#\n"

    def poll(self) -> bytes:
        """Nothing: the board speaks by itself."""
        return b""

    def profile(self, points: list[tuple[float, float]]) -> list[bytes]:
        """None: such boards follow set points only."""
        return []

    def start(self) -> bytes:
        """Nothing: there is no profile."""
        return b""

    def set_point(self, reference: float) -> bytes:
        """A line with the reference [rad]."""
        return f"r {reference:.6f}\n".encode()

    def stop(self) -> bytes:
        """A line that opens the drive."""
        return b"s\n"

    def resend(self, first: int, count: int) -> bytes:
        """Nothing: lines are not kept."""
        return b""

    def feed(self, data: bytes, host_time: float) -> list[Event]:
        """Rows of the whole lines in `data`."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[-LONGEST:]
        events: list[Event] = []
        for line in lines:
            events += self._line(line.decode("ascii", "replace").strip(), host_time)
        return events

    @property
    def damaged(self) -> int:
        """Lines so far that are no numbers, or of another number of columns than is known."""
        return self._damaged

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Unknown: lines have no numbers."""
        return ()

    def _line(self, line: str, host_time: float) -> list[Event]:
        if not line:
            return []
        if pairs := PAIR.findall(line):
            self._columns = self._columns or [name for name, _ in pairs]
            texts = [text for _, text in pairs] if [n for n, _ in pairs] == self._columns else []
        else:
            texts = re.split(r"[\s,;]+", line.lstrip("# "))
        try:
            numbers = [float(text) for text in texts]
        except ValueError:
            return self._header(line)
        if not self._columns:
            return []  # nobody knows yet of what
        if len(numbers) != len(self._columns) or not all(map(math.isfinite, numbers)):
            self._damaged += 1
            return []
        return [*self._introduced(), self._row(numbers, host_time)]

    def _header(self, line: str) -> list[Event]:
        names = _names(line.lstrip("# "))
        if not names or any(not re.fullmatch(r"[A-Za-z]\w*", name) for name in names):
            self._damaged += 1
            return []
        if names != self._columns:
            self._columns, self._said = names, False
        return self._introduced()

    def _introduced(self) -> list[Event]:
        if self._said:
            return []
        self._said = True
        units = dict(_split(name) for name in self._columns if _split(name)[0] != "time")
        return [About("text board", units, 0.0, 0.0)]

    def _row(self, numbers: list[float], host_time: float) -> Row:
        self._number += 1
        time, values = host_time, []
        for name, number in zip(self._columns, numbers, strict=True):
            what, unit = _split(name)
            if what == "time":
                time = number * TIMES.get(unit, 1.0)
            else:
                values.append(number)
        return Row(self._number, time, tuple(values))


def _names(header: str) -> list[str]:
    return [name for name in re.split(r"[\s,;]+", header.strip()) if name]


def _split(column: str) -> tuple[str, str]:
    """Name and unit of a `name_unit` column; unit 1 where it has none."""
    name, _, unit = column.rpartition("_")
    return (name, unit) if name else (column, "1")
