"""How one quantity of a data set varies: levels of a design, or a law from which it is drawn."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity

Draw = Callable[[float, float, float, np.random.Generator], float]


def _uniform(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    return rng.uniform(low, high)


def _log_uniform(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _spread(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    """The hand's own value times exp(spread z), z standard normal."""
    return nominal * math.exp(low * rng.standard_normal())


LAWS: dict[str, Draw] = {"uniform": _uniform, "log_uniform": _log_uniform, "spread": _spread}


@dataclass(frozen=True)
class Law:
    """`levels` (SI) are crossed with those of other quantities; a law `kind` is drawn from.

    `ends` are its limits (SI), or the relative spread and nothing.
    """

    levels: tuple[float, ...] = (0.0,)
    kind: str = ""
    ends: tuple[float, float] = (0.0, 0.0)

    def value(self, level: int, nominal: float, rng: np.random.Generator) -> float:
        """The level of that number, or a draw; `nominal` is the hand's own value (SI)."""
        return LAWS[self.kind](*self.ends, nominal, rng) if self.kind else self.levels[level]


def read_law(table: Table, key: str, unit: str, check: Callable[[float], float]) -> Law:
    """Read "3 mm", a list of such, or { uniform | log_uniform = [low, high] | spread = "0.1" }.

    `check` refuses a value out of bounds. Raises BadInput naming file and key.
    """
    given = table.content[key]
    if isinstance(given, dict):
        return _drawn(Table(given, table.where, tuple(LAWS), f"{table.prefix}{key}."), unit, check)
    texts = given if isinstance(given, list) else [given]
    if not texts:
        table.refuse(key, "is an empty list: expected at least one value")
    return Law(tuple(check(quantity(each, unit, table.name(key))) for each in texts))


def _drawn(table: Table, unit: str, check: Callable[[float], float]) -> Law:
    if len(table.content) != 1:
        table.refuse(next(iter(table.content), "uniform"), f"expected one of {', '.join(LAWS)}")
    ((kind, given),) = table.content.items()
    if kind == "spread":
        return Law(kind=kind, ends=(_share(table, given), 0.0))
    low, high = (check(quantity(x, unit, table.name(kind))) for x in table.items(kind, 2))
    if not (low < high and (low > 0.0 or kind == "uniform")):
        table.refuse(kind, "expected a lower, then a higher value, above zero where log_uniform")
    return Law(kind=kind, ends=(low, high))


def _share(table: Table, given: Any) -> float:
    share = quantity(given, "1", table.name("spread"))
    if not 0.0 <= share <= 1.0:
        table.refuse("spread", f"= {share:g}: expected a relative spread from 0 to 1")
    return share
