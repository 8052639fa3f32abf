"""A generic disturbance: it follows recordings by a law of free shape, and claims no cause."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hannes.core.effect import Effect
from hannes.core.kernels.jit import plain
from hannes.core.parameter import Parameter


@dataclass(frozen=True)
class Description:
    """An effect of free shape, and how its law is drawn: one value over one quantity.

    axis, unit: the quantity;  ends: its range
    value, value_unit: what is drawn over it
    law: of the quantity and then the effect's fitted parameters in their order
    """

    effect: Effect
    axis: str
    unit: str
    ends: tuple[float, float]
    value: str
    value_unit: str
    law: Callable[..., Any]

    @property
    def words(self) -> str:
        """`a torque on every joint over its angle`."""
        return f"{self.value} over {self.axis}"

    def at(self, places: np.ndarray, values: Sequence[float]) -> np.ndarray:
        """The value at places of the axis, shape (n,), with these parameters [SI]."""
        law = plain(self.law)
        return np.array([float(law(place, *values)) for place in places.tolist()])

    def slopes(self, places: np.ndarray, values: Sequence[float]) -> np.ndarray:
        """Derivatives of that by each parameter, shape (parameters, n)."""
        here, rows = self.at(places, values), []
        for number, each in enumerate(self.effect.fitted):
            step = 1e-4 * (each.bounds[1] - each.bounds[0])
            moved = [value + step * (k == number) for k, value in enumerate(values)]
            rows.append((self.at(places, moved) - here) / step)
        return np.array(rows)


def coefficients(unit: str, most: float, count: int = 5) -> tuple[Parameter, ...]:
    """Of Legendre's polynomials c_0 to c_4, and the finer the smaller at most."""
    return tuple(
        Parameter(
            f"c_{k}", 0.0, unit, (-most / max(k, 1), most / max(k, 1)),
            f"of Legendre's polynomial {k}", "choice", off=0.0,
        )
        for k in range(count)
    )  # fmt: skip


def waves(unit: str, most: float) -> tuple[Parameter, ...]:
    """Of the cosines c_0 to c_6."""
    return tuple(_wave(k, unit, most) for k in range(7))


def waves_from_zero(unit: str, most: float) -> tuple[Parameter, ...]:
    """Of the cosines c_1 to c_6, whose sum is taken from its value at 0; the finer the smaller."""
    return tuple(_wave(k, unit, most / k) for k in range(1, 7))


def _wave(k: int, unit: str, most: float) -> Parameter:
    return Parameter(f"c_{k}", 0.0, unit, (-most, most), f"of cosine {k}", "choice", off=0.0)
