"""What a recording says of the conversion that made it.

Anybody may have written it: what is not as `hannes convert` writes it is left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hannes.core.io.json_text import table
from hannes.core.io.limits import MAGNITUDE

SMALLEST = 1e-15  # of a factor between units


@dataclass(frozen=True)
class Conversion:
    """Columns, and factor and offset, by channel; intervals that the mapping cut [s].

    stated: what the mapping says of a channel's unit, scale, sign and side; missing: texts for no
    value; dropped: whether rows were left out.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    scales: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cuts: tuple[tuple[float, float], ...] = ()
    stated: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    dropped: bool = False


def conversion(text: str) -> Conversion:
    """What the text of a recording's `conversion` says, as far as it can be used."""
    said = table(text)
    rules = said.get("channels")
    known = {
        name: rule
        for name, rule in (rules.items() if isinstance(rules, dict) else ())
        if isinstance(rule, dict)
    }
    return Conversion(
        {name: str(rule["column"]) for name, rule in known.items() if _is_column(rule)},
        {name: scale for name, rule in known.items() if (scale := _scale(rule))},
        tuple(_cuts(said.get("cut_s"))),
        {name: _stated(rule.get("stated")) for name, rule in known.items()},
        tuple(each for each in _listed(said.get("missing")) if _is_text(each)),
        said.get("dropped_rows") not in (None, 0),
    )


def _stated(given: Any) -> dict[str, Any]:
    """Keys of a mapping as it has them, each of its own type."""
    if not isinstance(given, dict):
        return {}
    known = {key: given[key] for key in ("unit", "side") if _is_text(given.get(key))}
    if _numbers(given.get("scale", "")):
        known["scale"] = float(given["scale"])
    if isinstance(given.get("reversed"), bool):
        known["reversed"] = given["reversed"]
    return known


def _is_text(given: Any) -> bool:
    return isinstance(given, str) and given.isprintable()


def _listed(given: Any) -> list[Any]:
    return given if isinstance(given, list) else []


def _is_column(rule: Mapping[str, Any]) -> bool:
    given = rule.get("column")
    return type(given) is int or (isinstance(given, str) and given.isprintable())


def _scale(rule: Mapping[str, Any]) -> tuple[float, float] | None:
    factor, offset = rule.get("factor", 1.0), rule.get("offset", 0.0)
    if not (_numbers(factor, offset) and abs(factor) >= SMALLEST):
        return None
    return float(factor), float(offset)


def _cuts(given: Any) -> Iterator[tuple[float, float]]:
    for pair in _listed(given):
        if isinstance(pair, list) and len(pair) == 2 and _numbers(*pair):
            yield float(pair[0]), float(pair[1])


def _numbers(*given: Any) -> bool:
    return all(isinstance(each, int | float) and abs(each) <= MAGNITUDE for each in given)
