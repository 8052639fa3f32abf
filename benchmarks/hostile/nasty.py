"""Values that no file should hold, and mutations of structured content, text and bytes."""

import copy
import datetime
from typing import Any

import numpy as np

Rng = np.random.Generator

DEEP = 3000  # lists in one another: more than Python's stack holds
NUMBERS = (
    1e308, -1e308, 5e-324, 0, 0.0, -1, -1.5, 1, 3, 2**31, 2**63 - 1, 2**63, 10**400, -(10**30),
    float("inf"), float("nan"), 1e12, 1e300, 1e-300, 65536, 0.1, True, False,
)  # fmt: skip
TEXTS = (
    "",
    " ",
    "x",
    "0",
    "-1",
    "nan",
    "inf",
    "1e999",
    "1e308",
    "9" * 400,
    "1_0",
    "0x1F",
    "+-1",
    "1,5",
    "1 s",
    "-1 s",
    "1e9 s",
    "nan s",
    "1e400 m",
    "3 furlong",
    "9.8 rad",
    "1 rad/0",
    "5 m^99",
    "1e308 rad",
    "2 kHz",
    "12 V",
    "1e-320 A",
    "1 N m/(s",
    "\u2212" + "3 mm",
    "3 µm",
    "36 mm ",
    "0 mm",
    "1e5 N/m",
    "50 %",
    "canary:PLANT",
    "canary.py:EFFECT",
    "queue:Queue",
    "os:system",
    "canary_on_path:X",
    "__import__('os')",
    "../../../../etc/passwd",
    "/dev/zero",
    "/dev/full",
    "pipe",
    "folder",
    ".",
    "..",
    "/",
    "~",
    "a" * 300,
    "a\0b",
    "\u202e",
    "é" * 200,
    "\ud83d\ude00",
    "$x^{",
    "%s{}",
    "a\nb",
    "a\tb",
    "*.csv",
    "**",
    "[",
    "recording.csv",
    "recording.h5",
    "hand.toml",
    "experiment.toml",
    "campaign.toml",
    "simulated:experiment.toml",
    "measured:x",
    "dynamometer",
    "sphere",
    "prism",
    "hand",
    "axis",
    "finger",
    "supply_sag",
    "time",
    "position",
    "current",
    "[" * DEEP,
)
BYTES = 6  # changed at once


def value(rng: Rng) -> Any:
    """Something that may stand where another kind of value is expected."""
    kind = rng.integers(0, 10)
    if kind < 4:
        return NUMBERS[rng.integers(0, len(NUMBERS))]
    if kind < 8:
        return TEXTS[rng.integers(0, len(TEXTS))]
    others: tuple[Any, ...] = (
        [], {}, [1, 2], ["a"], {"a": 1}, [[]], [["0 s", "0 rad"]] * 3, nest(60),
        datetime.date(2026, 3, 3), ["0 s", "1 rad"], [float("nan")] * 4,
    )  # fmt: skip
    return copy.deepcopy(others[rng.integers(0, len(others))])


def nest(depth: int) -> list[Any]:
    """A list in a list in a list."""
    found: list[Any] = []
    for _ in range(depth):
        found = [found]
    return found


def places(content: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """All keys and indices that lead to something in nested content."""
    items = content.items() if isinstance(content, dict) else enumerate(content)
    found = []
    for key, each in items:
        found.append((*above, key))
        if isinstance(each, dict | list):
            found += places(each, (*above, key))
    return found


def changed(content: Any, rng: Rng) -> Any:
    """A copy of nested content with one to three changes of values, keys or order."""
    content = copy.deepcopy(content)
    for _ in range(rng.integers(1, 4)):
        known = places(content)
        if known:
            _change(content, known[rng.integers(0, len(known))], known, rng)
    return content


def _change(content: Any, place: tuple[Any, ...], known: list[tuple[Any, ...]], rng: Rng) -> None:
    holder = content
    for key in place[:-1]:
        holder = holder[key]
    last, kind = place[-1], rng.integers(0, 10)
    if kind < 5:
        holder[last] = value(rng)
    elif kind == 5 and isinstance(holder[last], str):
        holder[last] = text(holder[last], rng)
    elif kind == 6:
        del holder[last]
    elif kind == 7 and isinstance(holder, dict):
        other = known[rng.integers(0, len(known))][-1]
        holder[TEXTS[rng.integers(0, len(TEXTS))] if rng.random() < 0.5 else str(other)] = (
            holder.pop(last)
        )
    elif kind == 8 and isinstance(holder, list):
        holder.append(copy.deepcopy(holder[last]))
    else:
        holder[last] = scaled(holder[last], rng)


def scaled(given: Any, rng: Rng) -> Any:
    """A number, or a text that begins with one, times a power of two or ten."""
    factor = (-1.0, 2.0, 10.0, 1e3, 1e-3, 1e6, 2.0**32, 2.0**-64, 1e30)[rng.integers(0, 9)]
    if isinstance(given, bool | dict | list) or given is None:
        return given
    number, _, unit = str(given).partition(" ")
    try:
        new = float(number) * factor
    except ValueError:
        return given
    return f"{new!r} {unit}".strip() if isinstance(given, str) else new


def text(given: str, rng: Rng) -> str:
    """A text with a letter more, less or other, or with another beside it."""
    place = int(rng.integers(0, len(given) + 1))
    kind = rng.integers(0, 4)
    if kind == 0:
        return given[:place] + given[place + 1 :]
    if kind == 1:
        return given[:place] + chr(int(rng.integers(1, 0x2FF))) + given[place:]
    if kind == 2:
        return given[:place] + TEXTS[rng.integers(0, len(TEXTS))] + given[place:]
    return given.swapcase()


def lines(given: str, rng: Rng, mark: str = ",") -> str:
    """A table of text with one to three changes of cells, rows or columns."""
    rows = [row.split(mark) for row in given.split("\n")]
    for _ in range(rng.integers(1, 4)):
        k = int(rng.integers(0, len(rows))) if rng.random() < 0.7 else 0
        row, kind = rows[k], rng.integers(0, 9)
        c = int(rng.integers(0, len(row)))
        if kind < 3:
            row[c] = TEXTS[rng.integers(0, len(TEXTS))]
        elif kind < 5:
            row[c] = scaled(row[c], rng)
        elif kind == 5:
            rows.insert(k, list(rows[rng.integers(0, len(rows))]))
        elif kind == 6:
            rows.pop(k if len(rows) > 1 else 0)
            rows = rows or [[""]]
        elif kind == 7:
            row[c] = text(row[c], rng)
        else:
            row[c] = repr(float(flipped(np.float64(rng.normal()), rng)))
    return "\n".join(mark.join(map(str, row)) for row in rows)


def flipped(number: np.float64, rng: Rng) -> np.float64:
    """A number with one bit of its exponent flipped."""
    whole = np.float64(number).view(np.uint64) ^ np.uint64(1 << int(rng.integers(52, 64)))
    return whole.view(np.float64)


def octets(data: bytes, rng: Rng) -> bytes:
    """Bytes with some changed, half of the times near the start; some are cut off."""
    new = bytearray(data)
    size = len(new) if rng.random() < 0.5 else min(len(new), 4000)
    for place in rng.integers(0, size, int(rng.integers(1, BYTES + 1))):
        new[place] = rng.integers(0, 256)
    return bytes(new[: rng.integers(1, len(new))] if rng.random() < 0.1 else new)


def samples(values: np.ndarray, rng: Rng) -> np.ndarray:
    """An array of numbers with some of them, its type or its shape changed."""
    values = np.array(values)
    kind = rng.integers(0, 10)
    if kind < 4 and values.size:
        place = int(rng.integers(0, values.size))
        new = float(NUMBERS[rng.integers(0, 7)])
        number = flipped(np.float64(values.flat[place]), rng) if kind < 2 else np.float64(new)
        with np.errstate(all="ignore"):
            values.flat[place] = number if values.dtype.kind == "f" else values.dtype.type(1)
    elif kind == 4:
        with np.errstate(all="ignore"):
            values = values.astype(rng.choice(["<f4", ">f8", "<i4", "u1", "?", "c16", "S8"]))
    elif kind == 5:
        values = values[: int(rng.integers(0, len(values) + 1))] if values.ndim else values
    elif kind == 6:
        values = values.reshape(1, -1) if rng.random() < 0.5 else np.stack([values, values])
    elif kind == 7 and values.dtype.kind == "f":
        with np.errstate(all="ignore"):
            values = values * rng.choice([-1.0, 0.0, 1e3, 1e30, 1e300, np.nan])
    elif kind == 8 and values.ndim:
        values = values[::-1]
    else:
        values = np.array(rng.choice([0.0, 1.0, np.nan]))
    return values
