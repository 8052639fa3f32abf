"""Lines as a serial monitor shows them: stamps of the computer, and cells with their names.

`16:07:41.112 -> t_ms:5,pos_rad:0.1` becomes `16:07:41.112,5,0.1`, below the names stamp, t_ms and
pos_rad.
"""

import itertools
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

STAMPED = re.compile(r"\s*(\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?) -> ?(.*)")
STAMP = "stamp"  # name of the column
LOOKED_AT = 1000  # lines, for the names


@dataclass(frozen=True)
class SerialForm:
    """How lines are written: stamped, and with names before values, divided by `mark`."""

    delimiter: str
    stamped: bool
    mark: str = ""
    names: tuple[str, ...] = ()

    @property
    def head(self) -> str:
        """A line of names, where each line has them."""
        return self.delimiter.join((*((STAMP,) if self.stamped else ()), *self.names))

    def rest(self, line: str) -> str:
        """What the machine wrote."""
        return apart(line)[1] if self.stamped else line

    def plain(self, line: str) -> str | None:
        """Cells of a line without names, None where it is no whole sample."""
        stamp, rest = apart(line) if self.stamped else ("", line)
        if self.mark:
            values = named_values(rest, self.delimiter, self.mark)
            if not values.keys() & set(self.names):
                return None
            rest = self.delimiter.join(values.get(name, "") for name in self.names)
        return f"{stamp}{self.delimiter}{rest}" if self.stamped and rest.strip() else rest


def serial_form(lines: Iterable[str], delimiter: str, stamped: bool, mark: str) -> SerialForm:
    """The form of a file, with the names that most of its first lines have."""
    if not mark:
        return SerialForm(delimiter, stamped)
    counts: Counter[tuple[str, ...]] = Counter()
    for line in itertools.islice(lines, LOOKED_AT):
        rest = apart(line)[1] if stamped else line
        counts[tuple(named_values(rest, delimiter, mark))] += 1
    counts.pop((), None)
    names = counts.most_common(1)[0][0] if counts else ()
    return SerialForm(delimiter, stamped, mark, names)


def apart(line: str) -> tuple[str, str]:
    """Stamp of a line, and what stands behind it."""
    found = STAMPED.match(line)
    return (found[1], found[2]) if found else ("", line)


def named_values(line: str, delimiter: str, mark: str) -> dict[str, str]:
    """Values by name, none where one of the cells has no name."""
    cells: Sequence[str] = line.split() if delimiter == " " else line.split(delimiter)
    pairs = [cell.partition(mark) for cell in cells if cell.strip()]
    if not all(name.strip() and found and value.strip() for name, found, value in pairs):
        return {}
    return {name.strip(): value.strip() for name, _, value in pairs}
