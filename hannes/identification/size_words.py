"""Sizes in words: in a readable unit, with an interval, or rounded."""

import math
from collections.abc import Mapping
from typing import Any

_SMALLER = {"m": ("mm", 1e3), "s": ("ms", 1e3), "N m": ("mN m", 1e3)}


def readable_unit(unit: str) -> tuple[str, float]:
    """The unit in which a person is given a value, and the factor to it from SI."""
    return _SMALLER.get(unit, (unit, 1.0))


def size_text(parameter: dict[str, Any]) -> str:
    """`3.1 mm (2.9 to 3.3)`."""
    unit, factor = readable_unit(parameter["unit"])
    value, low, high = (factor * parameter[key] for key in ("value", "low", "high"))
    digits = _digits(max(abs(low), abs(high)), high - low)
    shown = f"{value:.{digits}g}" if unit == "1" else f"{value:.{digits}g} {unit}"
    return f"{shown} ({low:.{digits}g} to {high:.{digits}g})"


def _digits(size: float, width: float) -> int:
    """Digits that show two of an interval's width, three at least and six at most."""
    if not 0.0 < width < size:
        return 3
    return min(6, max(3, 2 + math.floor(math.log10(size)) - math.floor(math.log10(width))))


def value_text(parameter: Mapping[str, Any]) -> str:
    """`3.1 mm`."""
    unit, factor = readable_unit(parameter["unit"])
    shown = rounded(factor * parameter["value"])
    return shown if unit == "1" else f"{shown} {unit}"


def rounded(value: float) -> str:
    """Two digits, as they are read: 0.42, 5.6, 1,200."""
    return f"{value:.2g}" if abs(value) < 99.5 else f"{float(f'{value:.2g}'):,.0f}"
