"""Which column is which channel, in which unit: from names, units and the numbers themselves."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.spelled_units import COUNTS, unit_of

FloatArray = NDArray[np.float64]

WORDS = {
    "time": ("time", "t", "timestamp", "stamp", "zeit", "millis", "micros", "clock", "x_value",
             "realtime", "elapsed", "temps"),
    "reference": ("reference", "ref", "goal", "target", "setpoint", "set", "command", "cmd",
                  "desired", "des", "soll", "commanded", "action", "sp"),
    "position": ("position", "pos", "angle", "encoder", "enc", "theta", "q", "shaft", "ist",
                 "winkel", "measured", "present", "joint", "state"),
    "current": ("current", "cur", "curr", "amps", "i", "strom", "motor_current", "amp", "iq"),
    "duty": ("duty", "pwm", "dutycycle"),
    "supply": ("supply", "vbus", "voltage", "battery", "vbat", "vin", "volt", "spannung", "bus"),
    "force": ("force", "grip", "kraft"),
    "sensor": ("sensor", "dynamometer", "dyno", "loadcell", "cell"),
}  # fmt: skip
WEAK = ("present", "measured", "state", "joint", "set", "bus", "motor", "ist", "cell", "actual")
KINDS = {
    "time": ("s", "ms", "us", "ns"), "reference": ("rad", "mrad", "deg"),
    "position": ("rad", "mrad", "deg"), "current": ("A", "mA"), "duty": ("1", "%"),
    "supply": ("V", "mV"), "force": ("N", "mN", "kN"), "sensor": ("N", "mN", "kN"),
}  # fmt: skip
EPOCHS = ((1e9, 4e9, "s"), (1e12, 4e12, "ms"), (1e15, 4e15, "us"), (1e18, 4e18, "ns"))
QUICKEST, SLOWEST = 5e-5, 0.05  # s between samples of a log, as far as a clock is guessed
LABELS = ("trial", "run", "rep", "repeat", "episode", "episode_index", "cycle", "grasp", "label")


@dataclass(frozen=True)
class Guess:
    """What a column may be: channel, unit ("" unknown), why; `sure` where its name says all."""

    column: str | int
    channel: str
    unit: str
    why: str
    sure: bool


def split_name(name: str) -> tuple[list[str], str]:
    """Words of a column's name in lower case, and its unit ("" for none, "counts" for raw)."""
    inside = re.findall(r"[\[(]([^\])]+)[\])]", name)
    bare = re.sub(r"[\[(][^\])]*[\])]", " ", name)
    bare = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", bare)
    words = [word for word in re.split(r"[^A-Za-z0-9µμ°%]+", bare) if word]
    for text in inside:
        if (unit := unit_of(text)) is not None:
            return [word.lower() for word in words], unit
        if text.strip().lower() in COUNTS:
            return [word.lower() for word in words], "counts"
    lower = [word.lower() for word in words]
    if len(words) > 1 and lower[-1] in COUNTS:
        return lower[:-1], "counts"
    if len(words) > 1 and lower[-1] not in ("t", "i", "q") and (unit := unit_of(words[-1])):
        return lower[:-1], unit
    return lower, ""


def guesses(
    names: Sequence[str],
    units: Sequence[str],
    columns: Mapping[str, FloatArray],
    known: Sequence[str],
) -> list[Guess]:
    """A guess for each column that may be one of the plant's `known` channels, or time.

    names: of all columns, empty texts where there are none; units: of a line below them, may be
    empty; columns: numbers by name (n,), NaN where missing.
    """
    found = []
    for place, name in enumerate(names):
        unit = units[place] if place < len(units) else ""
        guess = _guess(name or place + 1, name, unit, columns.get(name), known)
        if guess is not None:
            found.append(guess)
    return found


def _guess(
    column: str | int, name: str, below: str, values: FloatArray | None, known: Sequence[str]
) -> Guess | None:
    words, unit = split_name(name)
    unit = unit or (unit_of(below) or ("counts" if below.strip().lower() in COUNTS else ""))
    scores = {
        channel: sum(_likeness(word, WORDS.get(channel, (channel,))) for word in words)
        for channel in ("time", *known)
    }
    channel, score = max(scores.items(), key=lambda pair: pair[1])
    if scores.get("reference", 0.0) >= 1.0 and channel == "position":
        channel, score = "reference", scores["reference"]  # "goal position" is a command
    if score <= 0.0:
        return None
    if unit not in ("", "counts") and unit not in KINDS.get(channel, (unit,)):
        fitting = [c for c, s in scores.items() if s > 0.0 and unit in KINDS.get(c, (unit,))]
        if not fitting:
            return None
        channel = fitting[0]
    if channel == "time" and not unit and values is not None:
        unit = _epoch(values) or _clock_unit(values)
    return Guess(column, channel, unit, f'its name "{name}"', score >= 1.0 and bool(unit))


def _likeness(word: str, spellings: Sequence[str]) -> float:
    """1 where a word is one of the spellings (0.3 of a weak one), a half where one begins it."""
    if word in spellings:
        return 0.3 if word in WEAK else 1.0
    return 0.5 * any(len(each) > 3 and word.startswith(each) for each in spellings)


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
    """A column that numbers or names runs: a known name, and few changes of value."""
    for place, name in enumerate(names):
        words, _ = split_name(name)
        if not set(words) & set(LABELS):
            continue
        cells = [row[place] for row in rows if place < len(row) and row[place]]
        changes = sum(a != b for a, b in pairwise(cells))
        if (cells and 0 < changes < max(len(cells) // 4, 2)) or (
            cells and len(cells) < len(rows) / 4
        ):
            return name
    return ""
