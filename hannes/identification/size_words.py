"""Sizes in words: in a readable unit, with an interval, or rounded."""

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
    shown = f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"
    return f"{shown} ({low:.3g} to {high:.3g})"


def value_text(parameter: Mapping[str, Any]) -> str:
    """`3.1 mm`."""
    unit, factor = readable_unit(parameter["unit"])
    shown = rounded(factor * parameter["value"])
    return shown if unit == "1" else f"{shown} {unit}"


def rounded(value: float) -> str:
    """Two digits, as they are read: 0.42, 5.6, 1,200."""
    return f"{value:.2g}" if abs(value) < 99.5 else f"{float(f'{value:.2g}'):,.0f}"
