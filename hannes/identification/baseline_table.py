"""What of the machine itself was off: its parameters refitted without any new effect."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

NORMAL = 1.96  # standard deviations on each side of a normal 95 % interval


@dataclass(frozen=True)
class Refitted:
    """One parameter of the refitted baseline, all sizes in `unit`.

    deviation: standard deviation after the fit;  prior: standard deviation before it
    owner: the object that the parameter belongs to, where it is not the machine's
    """

    name: str
    unit: str
    nominal: float
    value: float
    deviation: float
    prior: float
    bounds: tuple[float, float]
    owner: str = ""

    @property
    def moved(self) -> float:
        """By how many prior standard deviations the fit moved it."""
        return (self.value - self.nominal) / self.prior

    def plain(self) -> dict[str, Any]:
        """Its row in verdict.json; the 95 % interval ends at the bounds."""
        reach, (lowest, highest) = NORMAL * self.deviation, self.bounds
        return {
            "name": self.name,
            "of": self.owner,
            "unit": self.unit,
            "nominal": self.nominal,
            "value": self.value,
            "low": max(lowest, self.value - reach),
            "high": min(highest, self.value + reach),
            "moved": self.moved,
        }


def baseline_table(parameters: Iterable[Refitted], intervals_from: str) -> dict[str, Any]:
    """Key `baseline` of verdict.json: the parameters, those moved most first."""
    rows = sorted(parameters, key=lambda each: -abs(each.moved))
    return {"intervals_from": intervals_from, "parameters": [each.plain() for each in rows]}
