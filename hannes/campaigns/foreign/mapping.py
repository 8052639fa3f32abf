"""A mapping of a foreign file: its columns, units, signs, clock and alignment.

A column's raw numbers are put right first: signed, unwrapped. They become a channel's by
`raw * scale`, taken as `unit`, divided by the reducer's ratio where measured at the motor's side,
negated where `reversed`, plus `offset`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hannes.plants.protocol import Plant, commanded

FILLS = ("drop", "hold", "linear")  # of a missing value: its row is dropped, or it is filled
ORDERS = ("refuse", "drop", "mean", "sort")  # of stamps that are doubled or out of order
# Where a new run begins, besides a column's changes; stacked: arrays of two axes, a row a run.
SPLITS = ("restart", "blank", "header", "stacked")
CURRENTS = ("motor", "supply")  # where a current was measured
TARGETS = ("reference", "experiment")
YARDSTICKS = ("simulation", "command")


@dataclass(frozen=True)
class Column:
    """Where numbers stand: a column's name or number (from 1), the path of a dataset or variable.

    `index` is the place (from 1) in a dataset with two axes or in a list in a cell, 0 for none.
    """

    name: str | int
    index: int = 0


@dataclass(frozen=True)
class ChannelRule:
    """One channel: `factor` from raw values to the channel's unit, then `offset`.

    bits:     of a signed integer that was logged as unsigned, 0 for none
    turn:     raw values after which a counter begins anew, 0 for none
    supply:   a current at the supply's side, to be divided by the channel duty
    constant: the same throughout a run [channel's unit], without a column
    renewed:  rows between two readings of a channel that a logger wrote more often, 0 for each row
    source:   the further file that has the column, "" for the first
    stated:   the keys unit, scale, reversed and side as the mapping has them
    """

    column: Column | None
    factor: float = 1.0
    offset: float = 0.0
    fill: str = "drop"
    bits: int = 0
    turn: float = 0.0
    supply: bool = False
    constant: float = 0.0
    source: str = ""
    renewed: int = 0
    stated: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class TimeRule:
    """The clock: a column (`factor` makes seconds of it) or a sampling rate [Hz].

    iso:      stamps such as 2026-03-03 18:43:13.2; pattern: of strptime, for other customs
    resample: [Hz], 0 where times are kept
    turn:     raw ticks after which the clock begins anew, 0 for none
    order:    what happens to stamps that are doubled or out of order
    repeats:  whether rows of a logger that wrote its last frame again are kept
    cut:      stretches that are left out, as pairs of times [s] of the recording
    """

    column: Column | None
    factor: float = 1.0
    sampling: float = 0.0
    iso: bool = False
    from_zero: bool = False
    offset: float = 0.0
    resample: float = 0.0
    pattern: str = ""
    turn: float = 0.0
    order: str = "refuse"
    repeats: bool = True
    cut: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class TextRule:
    """How lines of text are divided; an empty delimiter is detected, `header` 0 means none.

    header, first: line numbers of the file, from 1, of the names and of the first numbers
    stamped: each line begins with a serial monitor's stamp, which becomes the column `stamp`
    pairs:  mark between name and value, where each cell has its name; header is 0 then
    skip:   regular expression of lines to be left out
    ragged: short rows are filled up with missing values, long ones cut
    """

    delimiter: str = ""
    decimal: str = "."
    comment: str = ""
    header: int = 1
    first: int = 2
    encoding: str = "utf-8"
    skip: str = ""
    ragged: bool = False
    stamped: bool = False
    pairs: str = ""


@dataclass(frozen=True)
class LongRule:
    """A long table: columns with the names of signals and with their values, a row a value."""

    names: Column
    values: Column


@dataclass(frozen=True)
class FurtherFile:
    """Another file of the same run, on a clock of its own.

    Its name is the first file's, in which `replace` gives way to `by`.
    """

    replace: str
    by: str
    time: TimeRule


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

    split:    a column whose changes of value part one file into several runs
    split_at: or one of SPLITS, "" for neither
    long:     where each row is one value: the channels' columns are names of signals
    files:    further files by the name that channels give as their source
    """

    plant: Plant
    channels: Mapping[str, ChannelRule]
    time: TimeRule
    text: TextRule = field(default_factory=TextRule)
    missing: tuple[str, ...] = ()
    split: Column | None = None
    experiment: str = ""
    align: AlignRule | None = None
    split_at: str = ""
    files: Mapping[str, FurtherFile] = field(default_factory=dict)
    long: LongRule | None = None

    @property
    def commands(self) -> frozenset[str]:
        """Channels that were asked for, not measured."""
        return commanded(self.plant)
