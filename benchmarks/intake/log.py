"""A log as a lab writes it, and the registry of the kinds of fault that are put into it."""

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.intake import kinds

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Log:
    """Columns of equal length: `time` [s] first, then what was logged.

    machine: "hand", "axis" or "servo"; columns: name -> (n,), NaN for an empty cell. The hand has
    position and maybe reference [rad], current [A], duty [1], supply [V], force and sensor [N];
    the axis reference and position [m], drive [V]; the servo reference and position [rad],
    current [A]. other: columns of another run of this machine, on its own clock; same_command:
    whether that was done under the same command. reason: why this log cannot show its fault in
    principle, as far as only what was drawn at random decides it.
    """

    machine: str
    columns: Mapping[str, FloatArray]
    other: Mapping[str, FloatArray] = field(default_factory=dict, repr=False)
    same_command: bool = False
    reason: str = ""

    @property
    def time(self) -> FloatArray:
        """Stamps [s]."""
        return self.columns["time"]

    @property
    def drive(self) -> str:
        """Name of the column that says how hard the machine is driven."""
        return "drive" if self.machine == "axis" else "current"

    def changed(self, **columns: FloatArray) -> "Log":
        """With columns replaced, or added."""
        return replace(self, columns={**self.columns, **columns})

    def rows(self, which: Any) -> "Log":
        """With these rows alone: indices in any order, or a mask."""
        return replace(self, columns={name: x[which] for name, x in self.columns.items()})

    def without(self, *names: str) -> "Log":
        """Without some columns."""
        return replace(self, columns={n: x for n, x in self.columns.items() if n not in names})


Inject = Callable[[Log, float, np.random.Generator], "Log | None"]


@dataclass(frozen=True)
class Kind:
    """One kind of fault.

    inject: see `kind`; right: kinds of findings, or words in their text, any of which names it;
    restorable: whether the sound log can be had back from the spoiled one by a key; graded:
    whether it has a size; hidden: the reason why a log cannot show it in principle, "" where it
    can, from the sound log and the size.
    """

    name: str
    inject: Inject
    right: tuple[str, ...]
    restorable: bool
    graded: bool
    hidden: Callable[[Log, float], str]


_KINDS: dict[str, Kind] = {}


def _never(log: Log, size: float) -> str:
    return ""


def kind(
    *right: str,
    restorable: bool = False,
    graded: bool = True,
    hidden: Callable[[Log, float], str] = _never,
) -> Callable[[Inject], Inject]:
    """Register `inject(log, size, rng) -> Log | None` under its own name.

    It returns the spoiled log, or None where the log has not what it would spoil. `size` is
    between 0 (nothing) and 1 (as bad as it gets); all that is drawn at random comes of `rng`, and
    is drawn in the same way for every size.
    """

    def registered(inject: Inject) -> Inject:
        name = inject.__name__.replace("_", " ")
        _KINDS[name] = Kind(name, inject, right, restorable, graded, hidden)
        return inject

    return registered


@cache
def all_kinds() -> Mapping[str, Kind]:
    """Every kind, by name: all functions in the modules of benchmarks/intake/kinds."""
    for module in sorted(each.name for each in pkgutil.iter_modules(kinds.__path__)):
        importlib.import_module(f"{kinds.__name__}.{module}")
    return dict(sorted(_KINDS.items()))
