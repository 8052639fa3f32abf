"""Which column is which channel, in which unit: from names, units and the numbers themselves."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.channel_words import from_supply, plain, scores, words_of
from hannes.campaigns.foreign.spelled_units import COUNTS, unit_of

FloatArray = NDArray[np.float64]

KINDS = {
    "time": ("s", "ms", "us", "ns"), "reference": ("rad", "mrad", "deg"),
    "position": ("rad", "mrad", "deg"), "current": ("A", "mA"), "duty": ("1", "%"),
    "supply": ("V", "mV"), "force": ("N", "mN", "kN"), "sensor": ("N", "mN", "kN"),
}  # fmt: skip
EPOCHS = ((1e9, 4e9, "s"), (1e12, 4e12, "ms"), (1e15, 4e15, "us"), (1e18, 4e18, "ns"))
QUICKEST, SLOWEST = 5e-5, 0.05  # s between samples of a log, as far as a clock is guessed
LABELS = (
    *("trial", "run", "rep", "repeat", "episode", "episode_index", "cycle", "grasp", "label"),
    *("versuch", "lauf", "durchgang", "messung", "essai", "prova", "ensayo"),
)
NUMBERED = re.compile(r"[^\W\d_]+[ _-]?\d+")  # a word with its number: V1, trial_2


@dataclass(frozen=True)
class Seen:
    """A column as it was found.

    column: by what a mapping names it; name: by which it is recognised; unit: where one stands
    apart from the name; values: numbers (n,), NaN where missing, None for texts such as dates.
    """

    column: str | int
    name: str
    unit: str = ""
    values: FloatArray | None = None


@dataclass(frozen=True)
class Guess:
    """What a column may be: channel, unit ("" unknown), why; `sure` where its name says all.

    supply: a current that its name says is drawn from the supply.
    """

    column: str | int
    channel: str
    unit: str
    why: str
    sure: bool
    supply: bool = False


def split_name(name: str) -> tuple[list[str], str]:
    """Words of a column's name in lower case, and its unit ("" for none, "counts" for raw)."""
    inside = re.findall(r"[\[(]([^\])]+)[\])]", name)
    words = words_of(re.sub(r"[\[(][^\])]*[\])]", " ", name))
    lower = [plain(word) for word in words]
    for text in inside:
        if (unit := unit_of(text)) is not None:
            return lower, unit
        if text.strip().lower() in COUNTS:
            return lower, "counts"
    if len(words) > 1 and lower[-1] in COUNTS:
        return lower[:-1], "counts"
    if len(words) > 1 and lower[-1] not in ("t", "i", "q") and (unit := unit_of(words[-1])):
        return lower[:-1], unit
    return lower, ""


def guesses(columns: Sequence[Seen], known: Sequence[str]) -> list[Guess]:
    """A guess for each column that may be one of the plant's `known` channels, or time."""
    found = (_guess(each, known) for each in columns)
    return [guess for guess in found if guess is not None]


def _guess(seen: Seen, known: Sequence[str]) -> Guess | None:
    words, unit = split_name(seen.name)
    words = [word for word in words if word != "sensors"]  # a group of whatever was measured
    below = seen.unit
    unit = unit or (unit_of(below) or ("counts" if below.strip().lower() in COUNTS else ""))
    found = scores(words, ("time", *known))
    channel, score = max(found.items(), key=lambda pair: pair[1])
    if found.get("reference", 0.0) >= 0.5 and channel == "position":
        channel, score = "reference", found["reference"]  # "goal position" is a command
    if score <= 0.0 and unit in KINDS["time"] and _increases(seen):
        return Guess(seen.column, "time", unit, f"it increases, in {unit}", False)
    if score <= 0.0:
        return None
    if unit not in ("", "counts") and unit not in KINDS.get(channel, (unit,)):
        fitting = [c for c, s in found.items() if s > 0.0 and unit in KINDS.get(c, (unit,))]
        if not fitting:
            return None
        channel = fitting[0]
    if channel == "time" and not unit and seen.values is not None:
        unit = _epoch(seen.values) or _clock_unit(seen.values)
    why = f'its name "{seen.name}"'
    supply = channel == "current" and from_supply(words)
    return Guess(
        seen.column, channel, unit, why, score >= 1.0 and bool(unit) and not supply, supply
    )


def _increases(seen: Seen) -> bool:
    """Whether a column goes up from row to row, as a clock under another name does."""
    values = seen.values
    return values is not None and values.size > 1 and bool(np.all(np.diff(values) > 0.0))


def _epoch(values: FloatArray) -> str:
    """Unit of a clock that counts from 1970, "" where it does not."""
    middle = float(np.nanmedian(values)) if values.size else 0.0
    return next((unit for low, high, unit in EPOCHS if low <= middle <= high), "")


def _clock_unit(values: FloatArray) -> str:
    """The one unit in which a clock's steps are a sampling rate of 20 Hz to 20 kHz."""
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(steps)) if steps.size else 0.0
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if 1.01 * SLOWEST > step * size > 0.99 * QUICKEST:
            return unit
    return ""


def label_column(names: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A column that numbers or names runs: a known name, and few changes of value.

    The beginning of a log may hold its first run alone: then nothing changes there.
    """
    for name, cells in _cells(names, rows):
        words, _ = split_name(name)
        few = _changes(cells) < max(len(cells) // 4, 2)
        if set(words) & set(LABELS) and (few or len(cells) < len(rows) / 4):
            return name
    return ""


def label_array(columns: Mapping[str, FloatArray], size: int) -> str:
    """An array of `size` samples that counts runs: named so, and never going back, "" for none."""
    for name, values in columns.items():
        words, _ = split_name(name)
        steps = np.diff(values)
        few = 0 < np.count_nonzero(steps) < max(size // 4, 2)
        if values.size == size and set(words) & set(LABELS) and few and (steps >= 0.0).all():
            return name
    return ""


def maybe_label(names: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A column of words with numbers that seldom change: they may name runs, or states of one."""
    for name, cells in _cells(names, rows):
        if all(map(NUMBERED.fullmatch, cells)) and 0 < _changes(cells) < max(len(cells) // 4, 2):
            return name
    return ""


def _cells(
    names: Sequence[str], rows: Sequence[Sequence[str]]
) -> Iterator[tuple[str, Sequence[str]]]:
    """Names of columns, and their cells where any is filled."""
    for place, name in enumerate(names):
        if cells := [row[place] for row in rows if place < len(row) and row[place]]:
            yield name, cells


def _changes(cells: Sequence[str]) -> int:
    return sum(a != b for a, b in pairwise(cells))
