"""Text with a unit to a float in SI and back: ``quantity("3.1 mm", "m", name) -> 0.0031``.

Units are read by a small grammar (names, powers, one slash per divisor, brackets), so no text from
a file is ever evaluated; pint only gives the factor of each name. Angle counts as a dimension here,
unlike in pint: ``"9.84"`` is no angle, and ``"100 1/s"`` no angular speed.
"""

import json
import math
import re
from decimal import Decimal
from functools import lru_cache
from typing import NoReturn

from hannes.core.errors import BadInput, printable
from hannes.core.io.unit_factors import worth

LONGEST = 80  # characters; no real value with its unit is longer

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\d.])", re.ASCII)
_FACTOR = re.compile(r"([A-Za-zµμΩ°%_]+)(?:\^?([1-9])|\^(-[1-9]))?")
_PLAIN = str.maketrans({"²": "^2", "³": "^3", "·": " ", "*": " ", "\u2212": "-"})

_KINDS = {
    "1": ("a plain number", "0.4"),
    "m": ("a length", "3.1 mm"),
    "s": ("a time", "20 ms"),
    "kg": ("a mass", "24 g"),
    "rad": ("an angle", "1.57 rad"),
    "A": ("a current", "250 mA"),
    "V": ("a voltage", "12 V"),
    "K": ("a temperature difference", "22 K"),
    "degC": ("a temperature", "25 degC"),
    "N": ("a force", "3 N"),
    "Hz": ("a frequency", "1 kHz"),
    "ohm": ("a resistance", "0.6 ohm"),
    "H": ("an inductance", "0.2 mH"),
    "m/s": ("a speed", "2 mm/s"),
    "m/s^2": ("an acceleration", "9.81 m/s^2"),
    "rad/s": ("an angular speed", "100 rpm"),
    "N m": ("a torque", "15 mN m"),
    "N/m": ("a stiffness", "8344 N/m"),
    "N s/m": ("a damping", "59 N s/m"),
    "N m/rad": ("an angular stiffness", "24.7 mN m/rad"),
    "N m s/rad": ("an angular damping", "0.1 mN m s/rad"),
    "kg m^2": ("a moment of inertia", "4e-7 kg m^2"),
}


class _BadUnit(Exception):
    """A unit text that cannot be read; the message becomes part of a BadInput."""


def quantity(text: object, unit: str, name: str) -> float:
    """Return the value of `text` ("3.1 mm") in `unit` ("m"); `name` is used in messages.

    A bare number passes only where `unit` is "1". Decimal arithmetic makes the result the float
    nearest to what was written. Raises BadInput for anything else.
    """
    if isinstance(text, int | float) and not isinstance(text, bool) and unit != "1":
        _refuse(name, text, "has no unit", unit)
    if isinstance(text, int | float) and not isinstance(text, bool):
        return _finite(_as_float(text), name, text, unit)
    if not isinstance(text, str):
        _refuse(name, text, f"is not {_kind(unit)}", unit)
    return _finite(_parse(text, unit, name), name, text, unit)


def text(value: float, unit: str) -> str:
    """Return `value`, given in `unit`, as text that `quantity` reads back to the same float."""
    number = float(value)
    if not math.isfinite(number):
        raise BadInput(f"{number} cannot be written as a value in {unit}: it is not finite")
    return repr(number) if unit == "1" else f"{number!r} {unit}"


def unit_scale(from_unit: str, to_unit: str) -> float:
    """Return the factor that takes a value in `from_unit` to `to_unit`; BadInput if none exists."""
    try:
        return float(_ratio(from_unit, to_unit))
    except _BadUnit as error:
        raise BadInput(f'"{from_unit}" does not convert to "{to_unit}": {error}') from None


def _parse(text: str, unit: str, name: str) -> float:
    if len(text) > LONGEST:
        _refuse(name, text, f"is longer than {LONGEST} characters", unit)
    start = _NUMBER.match(text.translate(_PLAIN).strip())
    if start is None:
        _refuse(name, text, "does not start with a finite number", unit)
    given = start.string[start.end() :].strip()
    try:
        factor = _ratio(given or "1", unit)
    except _BadUnit as error:
        _refuse(name, text, "has no unit" if not given else str(error), unit)
    number = float(start.group())
    if number == 0.0 or math.isinf(number):
        return number
    return float(Decimal(start.group()) * factor)


@lru_cache(maxsize=1024)
def _ratio(from_unit: str, to_unit: str) -> Decimal:
    """Return the exact factor between two unit texts; raises _BadUnit."""
    scale_from, dimension_from = _reduce(from_unit)
    scale_to, dimension_to = _reduce(to_unit)
    if dimension_from != dimension_to:
        raise _BadUnit(f"is not {_kind(to_unit)}")
    return scale_from / scale_to


def _reduce(unit: str) -> tuple[Decimal, dict[str, float]]:
    """Return (factor to base units, powers of the base units) of a unit text."""
    scale, dimension = Decimal(1), dict[str, float]()
    for name, power in _factors(unit):
        if (found := worth(name)) is None:
            raise _BadUnit(f'has the unknown unit "{name}"')
        factor, base = found
        scale *= factor**power
        for key, exponent in base:
            dimension[key] = dimension.get(key, 0) + exponent * power
    return scale, {key: power for key, power in dimension.items() if power}


def _factors(unit: str) -> list[tuple[str, int]]:
    """Split "N s/m^2" into [("N", 1), ("s", 1), ("m", -2)]."""
    if len(unit) > LONGEST:
        raise _BadUnit(f"has a unit longer than {LONGEST} characters")
    first, *divisors = unit.translate(_PLAIN).split("/")
    factors = [] if first.strip() == "1" else _product(first)
    for divisor in divisors:
        below = _product(divisor)
        if len(below) > 1 and "(" not in divisor:
            raise _BadUnit(f'has the ambiguous divisor "{divisor.strip()}", bracket it')
        factors += [(name, -power) for name, power in below]
    return factors


def _product(text: str) -> list[tuple[str, int]]:
    inner = text.strip()
    if inner.startswith("(") and inner.endswith(")"):
        inner = inner[1:-1]
    found = [_FACTOR.fullmatch(word) for word in inner.split()]
    if not found or None in found:
        raise _BadUnit(f'has the unreadable unit "{_clean(text.strip())}"')
    return [(m[1], int(m[2] or m[3] or 1)) for m in found if m]


def _as_float(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _finite(value: float, name: str, came: object, unit: str) -> float:
    if not math.isfinite(value):
        _refuse(name, came, "is not finite", unit)
    return value


def _kind(unit: str) -> str:
    return _KINDS.get(_canonical(unit), (f"in {unit}", ""))[0]


def _canonical(unit: str) -> str:
    return re.sub(r"([A-Za-z])(\d)", r"\1^\2", unit.translate(_PLAIN))


def _refuse(name: str, came: object, fault: str, unit: str) -> NoReturn:
    example = _KINDS.get(_canonical(unit), ("", f"0.5 {unit}"))[1]
    wanted = "a number" if unit == "1" else f"a value in {unit}"
    raise BadInput(f'{name} = {_shown(came)} {fault}: expected {wanted}, such as "{example}"')


def _shown(came: object) -> str:
    try:
        shown = json.dumps(came, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        shown = f"a {type(came).__name__}"
    return _clean(shown)


def _clean(text: str) -> str:
    """Return `text` short and on one line."""
    shown = printable(text[:LONGEST])
    return shown if len(shown) <= 50 else shown[:47] + "..."
