"""A mapping of a foreign file: its columns, units, signs, clock and alignment.

A column's numbers become a channel's by `raw * scale`, taken as `unit`, divided by the reducer's
ratio where measured at the motor's side, negated where `reversed`, plus `offset`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from hannes.plants.protocol import Plant

FILLS = ("drop", "hold", "linear")  # of a missing value: its row is dropped, or it is filled
TARGETS = ("reference", "experiment")
YARDSTICKS = ("simulation", "command")


@dataclass(frozen=True)
class Column:
    """Where numbers stand: a column's name or number (from 1), the path of a dataset or variable.

    `index` is the column (from 1) of a dataset with two axes, 0 where it has one.
    """

    name: str | int
    index: int = 0


@dataclass(frozen=True)
class ChannelRule:
    """One channel: `factor` from raw values to the channel's unit, then `offset`."""

    column: Column
    factor: float = 1.0
    offset: float = 0.0
    fill: str = "drop"


@dataclass(frozen=True)
class TimeRule:
    """The clock: a column (`factor` makes seconds of it) or a sampling rate [Hz].

    `iso`: stamps such as 2026-03-03 18:43:13.2. `resample` [Hz] is 0 where times are kept.
    """

    column: Column | None
    factor: float = 1.0
    sampling: float = 0.0
    iso: bool = False
    from_zero: bool = False
    offset: float = 0.0
    resample: float = 0.0


@dataclass(frozen=True)
class TextRule:
    """How lines of text are divided; an empty delimiter is detected, `header` 0 means none.

    header, first: line numbers of the file, from 1, of the names and of the first numbers.
    """

    delimiter: str = ""
    decimal: str = "."
    comment: str = ""
    header: int = 1
    first: int = 2
    encoding: str = "utf-8"


@dataclass(frozen=True)
class AlignRule:
    """Alignment of two clocks, by the motion of one channel; times in s."""

    to: str
    by: str
    channel: str
    within: float
    lag: float


@dataclass(frozen=True)
class ColumnMap:
    """A mapping as read from TOML; `missing` lists texts that mean no value.

    `split`: a column whose changes of value part one file into several runs.
    """

    plant: Plant
    channels: Mapping[str, ChannelRule]
    time: TimeRule
    text: TextRule = field(default_factory=TextRule)
    missing: tuple[str, ...] = ()
    split: Column | None = None
    experiment: str = ""
    align: AlignRule | None = None
