"""How one quantity of a data set varies: levels of a design, or a random distribution."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity

Sampler = Callable[[float, float, float, np.random.Generator], float]


def _uniform(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    return rng.uniform(low, high)


def _log_uniform(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _spread(low: float, high: float, nominal: float, rng: np.random.Generator) -> float:
    """The hand's own value times exp(spread z), z standard normal."""
    return nominal * math.exp(low * rng.standard_normal())


SAMPLERS: dict[str, Sampler] = {"uniform": _uniform, "log_uniform": _log_uniform, "spread": _spread}


@dataclass(frozen=True)
class Distribution:
    """Levels of a design, or a random distribution of one quantity.

    `levels` (SI) are crossed with those of other quantities. `kind` names a distribution, empty
    for levels. `ends` are its limits (SI), or the relative spread and zero.
    """

    levels: tuple[float, ...] = (0.0,)
    kind: str = ""
    ends: tuple[float, float] = (0.0, 0.0)

    def value(self, level: int, nominal: float, rng: np.random.Generator) -> float:
        """Return the level of that number, or a random value; `nominal` is the hand's own (SI)."""
        return SAMPLERS[self.kind](*self.ends, nominal, rng) if self.kind else self.levels[level]


def read_distribution(
    table: Table, key: str, unit: str, check: Callable[[float], float]
) -> Distribution:
    """Read "3 mm", a list of such, or { uniform | log_uniform = [low, high] | spread = "0.1" }.

    `unit` is that of the values. `check` refuses a value out of bounds. Raises BadInput naming
    file and key.
    """
    given = table.content[key]
    if isinstance(given, dict):
        return _random(
            Table(given, table.where, tuple(SAMPLERS), f"{table.prefix}{key}."), unit, check
        )
    texts = given if isinstance(given, list) else [given]
    if not texts:
        table.refuse(key, "is an empty list: expected at least one value")
    return Distribution(tuple(check(quantity(each, unit, table.name(key))) for each in texts))


def _random(table: Table, unit: str, check: Callable[[float], float]) -> Distribution:
    if len(table.content) != 1:
        table.refuse(next(iter(table.content), "uniform"), f"expected one of {', '.join(SAMPLERS)}")
    ((kind, given),) = table.content.items()
    if kind == "spread":
        return Distribution(kind=kind, ends=(_share(table, given), 0.0))
    low, high = (check(quantity(x, unit, table.name(kind))) for x in table.items(kind, 2))
    if not (low < high and (low > 0.0 or kind == "uniform")):
        table.refuse(kind, "expected a lower, then a higher value, above zero where log_uniform")
    return Distribution(kind=kind, ends=(low, high))


def _share(table: Table, given: Any) -> float:
    share = quantity(given, "1", table.name("spread"))
    if not 0.0 <= share <= 1.0:
        table.refuse("spread", f"= {share:g}: expected a relative spread from 0 to 1")
    return share
