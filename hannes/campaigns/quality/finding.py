"""One thing found in a recording, in a plain line with what to do."""

from dataclasses import dataclass
from typing import Any

# A fault must not be fitted as it is; of a recording with a warning a part misleads.
LEVELS = ("fault", "warning", "note")
KINDS = (
    *("gap", "uneven", "drift", "late-start", "command", "clock", "held", "lost"),  # of time
    *(
        "dead",
        "saturated",
        "frozen",
        "jump",
        "missing",
        "resolution",
        "coarse",
        "zero",
        "range",
        "slip",
        "crosstalk",
    ),  # of sensors
    *("unit", "sign", "unlike", "magnitude", "swapped", "signed", "pace", "other"),  # of columns
    *("disabled", "supply", "mixed"),  # of machines
)


@dataclass(frozen=True)
class Finding:
    """One data-quality issue.

    `kind` is one of KINDS; `channel` shows it; `time` [s] is its first instant, None for always.
    `text` says what was found and what to do; `size` is its magnitude, in the unit that text names.
    `mend`: the same as lines to be added to a mapping, such as `time.order = "sort"`, or
    "leave out channels.NAME", "leave out the file".
    """

    level: str
    kind: str
    channel: str
    text: str
    time: float | None = None
    size: float | None = None
    mend: tuple[str, ...] = ()

    def __str__(self) -> str:
        when = "" if self.time is None else f" at {self.time:.4g} s"
        return f"{self.level}: {self.channel}{when}: {self.text}"


def fault(kind: str, channel: str, text: str, **more: Any) -> Finding:
    """A fault: fitted as it is, the recording misleads."""
    return Finding("fault", kind, channel, text, **more)


def warning(kind: str, channel: str, text: str, **more: Any) -> Finding:
    """A warning: usable, but part of it misleads."""
    return Finding("warning", kind, channel, text, **more)


def note(kind: str, channel: str, text: str, **more: Any) -> Finding:
    """A note: nothing wrong, good to know."""
    return Finding("note", kind, channel, text, **more)
