"""Named parameters with units and bounds, and the plain vector that compiled code reads."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from hannes.core.errors import BadInput, nearest

EARLIER = ("charge", "time")  # of the motor [A s], and of all earlier runs [s]


@dataclass(frozen=True)
class Parameter:
    """One number of a model: SI value, unit, inclusive bounds, meaning and source.

    `off` is the value at which an effect vanishes exactly; None where there is no such value.
    `tried` are starting values of a search without prior knowledge; without them they are spread
    over the bounds. A count needs them: between whole numbers an effect may have no signature.
    `turns`, added to it, reverses the sign of its effect, as half a turn does for a phase.
    `shared` names the value that like parts have in common, where this is one part's share of it.
    `earlier` names what earlier runs of a campaign did, where that sets it and no fit moves it:
    "charge" of the motor [A s] or their "time" [s].
    """

    name: str
    value: float
    unit: str
    bounds: tuple[float, float]
    doc: str
    source: str = "choice"
    off: float | None = None
    tried: tuple[float, ...] = ()
    turns: float | None = None
    shared: str = ""
    earlier: str = ""

    def __post_init__(self) -> None:
        _require_numbers(self)
        low, high = self.bounds
        if not low < high:
            raise BadInput(f"{self.name}: lower bound {low:g} is not below upper bound {high:g}")
        off = () if self.off is None else (self.off,)
        for value in (self.value, *self.tried, *off):
            self.check(value)
        if self.earlier not in ("", *EARLIER):
            raise BadInput(
                f'{self.name}: earlier = "{self.earlier}": expected one of {", ".join(EARLIER)}'
            )

    def check(self, value: float) -> float:
        """Return `value` where it is finite and inside the bounds; raise BadInput otherwise."""
        low, high = self.bounds
        if not math.isfinite(value):
            raise BadInput(f"{self.name} = {value} [{self.unit}] is not a finite number")
        if value < low or value > high:
            side, bound = ("below its lower", low) if value < low else ("above its upper", high)
            raise BadInput(
                f"{self.name} = {value:g} [{self.unit}] is {side} bound {bound:g}; "
                f"choose a value between {low:g} and {high:g} {self.unit}"
            )
        return float(value)


def _require_numbers(declared: Parameter) -> None:
    """Refuse what is no number where one belongs: a user's file declares parameters, too."""
    optional = (each for each in (declared.off, declared.turns) if each is not None)
    for each in (
        declared.value,
        *optional,
        *_items(declared, "bounds"),
        *_items(declared, "tried"),
    ):
        if isinstance(each, bool) or not isinstance(each, Real):
            raise BadInput(f"{declared.name}: expected numbers, got {each!r}")
    if len(declared.bounds) != 2:
        raise BadInput(f"{declared.name}: expected two bounds, got {len(declared.bounds)}")


def _items(declared: Parameter, field: str) -> tuple[object, ...]:
    given = getattr(declared, field)
    if not isinstance(given, tuple | list):
        raise BadInput(f"{declared.name}: expected numbers in brackets for {field}, got {given!r}")
    return tuple(given)


def group(prefix: str, *parameters: Parameter) -> tuple[Parameter, ...]:
    """Give every parameter of one part the part's name: `motor` + `inertia`."""
    return tuple(replace(each, name=f"{prefix}.{each.name}") for each in parameters)


class ParameterSet(Mapping[str, float]):
    """Immutable ordered mapping from full names to SI values."""

    def __init__(self, declared: Iterable[Parameter]) -> None:
        self.declared = {each.name: each for each in declared}
        self._values = {name: each.value for name, each in self.declared.items()}

    def __getitem__(self, name: str) -> float:
        found = self._values.get(name)  # called thousands of times in a fit
        return self.require(name).value if found is None else found

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"ParameterSet({', '.join([f'{len(self)} parameters', *self.changed()])})"

    def changed(self) -> list[str]:
        """`name=value` of each that is not as declared."""
        declared = self.declared
        return [f"{n}={x:g}" for n, x in self._values.items() if x != declared[n].value]

    def require(self, name: str) -> Parameter:
        """Return the declaration of `name`; raise BadInput naming the nearest match."""
        if name not in self.declared:
            raise BadInput(f'unknown parameter "{name}"{nearest(name, self.declared)}')
        return self.declared[name]

    def with_values(self, values: Mapping[str, float]) -> "ParameterSet":
        """Return a copy with other values; raise BadInput on unknown names or bounds."""
        checked = {name: self.require(name).check(value) for name, value in values.items()}
        changed = ParameterSet(())
        changed.declared = self.declared
        changed._values = {**self._values, **checked}
        return changed

    def vector(self) -> np.ndarray:
        """Values in declared order, shape (number of parameters,), float64."""
        return np.fromiter(self._values.values(), float, len(self._values))
