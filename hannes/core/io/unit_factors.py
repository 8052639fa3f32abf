"""Factor and base units of each unit name, by pint; cached on disk, as pint starts slowly."""

import json
from collections.abc import Mapping
from contextlib import suppress
from decimal import Decimal
from functools import cache, lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import write_text
from hannes.core.io.cache import cache_home

if TYPE_CHECKING:
    import pint

Worth = tuple[Decimal, tuple[tuple[str, float], ...]]


@lru_cache(maxsize=256)
def worth(name: str) -> Worth | None:
    """Return (factor, base units with powers) of one unit name, None where pint has none.

    A scale with its own zero (degC) or a logarithm (dB) has no factor: it converts to itself only.
    """
    if name not in _kept():
        found = _by_pint(name)
        if found is None:
            return None
        _kept()[name] = found
        _keep(_kept())
    return _kept()[name]


def _by_pint(name: str) -> Worth | None:
    registry = _registry()
    try:
        unit = registry.parse_units(name)
        zero = registry.Quantity(Decimal(0), unit).to_root_units()
        one = registry.Quantity(Decimal(1), unit).to_root_units()
    except Exception:  # pint raises many kinds; each means an unknown name
        return None
    if zero.magnitude != 0:
        return Decimal(1), ((str(unit), 1.0),)
    base: Any = one.unit_items()  # powers may be halves (Gaussian units)
    return Decimal(one.magnitude), tuple((key, float(power)) for key, power in base)


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _path() -> Path:
    return cache_home() / f"units_{version('pint')}.json"


@cache
def _kept() -> dict[str, Worth]:
    """Units that earlier processes looked up; none where the file cannot be read."""
    try:
        rows = json.loads(_path().read_text(encoding="utf-8"))
        return {
            name: (Decimal(factor), tuple((key, float(power)) for key, power in base))
            for name, (factor, base) in rows.items()
        }
    except (OSError, ValueError, ArithmeticError, TypeError, AttributeError):
        return {}


def _keep(known: Mapping[str, Worth]) -> None:
    rows = {name: [str(factor), base] for name, (factor, base) in known.items()}
    with suppress(OSError, BadInput):  # else the next process uses pint again
        _path().parent.mkdir(parents=True, exist_ok=True)
        write_text(_path(), json.dumps(rows))
