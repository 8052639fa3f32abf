"""An effect: physics that a model may lack, declared in one file.

Its kernel's signature is the declaration: arguments are looked up by name among the effect's
own parameters and states, then among the plant's parameters (`motor_dry_friction` for
`motor.dry_friction`), states and channels. The kernel returns what it adds to each channel
of `writes`, then the rate of each of its states.
"""

import inspect
import pkgutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from keyword import iskeyword
from typing import Any

from hannes.core import former_names
from hannes.core.errors import BadInput
from hannes.core.kernels.jit import plain
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@dataclass(frozen=True, repr=False)
class Term:
    """One kernel of an effect, the channels it adds to and the states whose rates it returns.

    `unit` is that of what it adds, where the effect's own parameters fix it: a plant that has
    `writes` in another unit cannot carry it.
    """

    kernel: Callable[..., Any]
    writes: tuple[str, ...]
    states: tuple[str, ...] = ()
    unit: str = ""

    def __post_init__(self) -> None:
        declared: tuple[object, ...] = (self.writes, self.states)  # a user's own may be a text
        if any(isinstance(each, str) for each in declared):
            raise BadInput(
                f'a term of {plain(self.kernel).__name__}: expected names in a tuple, ("a",)'
            )
        object.__setattr__(self, "writes", tuple(map(former_names.channel, self.writes)))

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the kernel's arguments, in order."""
        names = inspect.signature(plain(self.kernel)).parameters
        return tuple(map(former_names.channel, names))

    def __repr__(self) -> str:
        rates = f", states={self.states!r}" if self.states else ""
        return f"Term({plain(self.kernel).__name__}, writes={self.writes!r}{rates})"

    def __reduce__(self) -> tuple[Any, ...]:
        """A kernel of hannes is pickled by its name, one of a user's own by numba."""
        function = plain(self.kernel)
        kernel: Any = f"{function.__module__}:{function.__qualname__}"
        if not kernel.startswith("hannes.") or "<locals>" in kernel:
            kernel = self.kernel
        return _term, (kernel, self.writes, self.states, self.unit)


def _term(
    kernel: Callable[..., Any] | str, writes: tuple[str, ...], states: tuple[str, ...], unit: str
) -> Term:
    found = pkgutil.resolve_name(kernel) if isinstance(kernel, str) else kernel
    return Term(found, writes, states, unit)


@dataclass(frozen=True, repr=False)
class Effect:
    """A physical effect that can be added to a model without touching the model.

    `meaning` is one sentence in plain words; `equation` and `source` say where it comes from.
    Its amplitudes carry `off`; with every amplitude at `off` the effect vanishes exactly.
    """

    name: str
    meaning: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    terms: tuple[Term, ...]
    states: tuple[Slot, ...] = ()

    def __post_init__(self) -> None:
        parts = [each.name for each in self.parameters] + [each.name for each in self.states]
        for name in (self.name, *parts):
            if not name.isidentifier() or iskeyword(name):
                what = "expected a name of letters, digits and _, as Python has it"
                raise BadInput(f"effect {self.name!r}: {name!r} is no name; {what}")
        if not self.amplitudes:
            raise BadInput(f"effect {self.name}: no parameter declares `off`")
        own = {each.name for each in self.parameters} | {each.name for each in self.states}
        used = {name for term in self.terms for name in term.arguments}
        if unused := sorted(own - used):
            raise BadInput(f"effect {self.name}: no kernel takes its {', '.join(unused)}")
        kernels = [self.kernel_name(term) for term in self.terms]
        if len(set(kernels)) < len(kernels):
            raise BadInput(f"effect {self.name}: two of its kernels have the same name")
        rated = [name for term in self.terms for name in term.states]
        if sorted(rated) != sorted(each.name for each in self.states):
            raise BadInput(f"effect {self.name}: each state needs its rate from exactly one term")

    @property
    def amplitudes(self) -> tuple[Parameter, ...]:
        """The parameters whose `off` values, taken together, make the effect vanish."""
        return tuple(each for each in self.parameters if each.off is not None)

    @property
    def fitted(self) -> tuple[Parameter, ...]:
        """All parameters but those that earlier runs set."""
        return tuple(each for each in self.parameters if not each.earlier)

    @property
    def grows(self) -> bool:
        """Whether earlier runs of a campaign set some of it."""
        return len(self.fitted) < len(self.parameters)

    @property
    def has_phase(self) -> bool:
        """Whether it goes to and fro with something, at a phase of its own."""
        return any(each.turns is not None for each in self.parameters)

    def kernel_name(self, term: Term) -> str:
        """Name of one of its kernels in generated code: no plant's function begins like this."""
        return f"{self.name}__{plain(term.kernel).__name__}"

    def full_name(self, parameter: str) -> str:
        """Name under which a parameter of this effect is known outside."""
        return f"{self.name}.{parameter}"

    @property
    def acts(self) -> str:
        """What it changes, in a line."""
        return f"adds to: {', '.join(name for term in self.terms for name in term.writes)}"

    def __repr__(self) -> str:
        sizes = ", ".join(f"{each.name} [{each.unit}]" for each in self.parameters)
        return f"Effect({self.name}: {sizes})"

    def __str__(self) -> str:
        """Equation, meaning, source and parameters, as `hannes effects NAME` shows them."""
        lines = [self.name, f"  {self.meaning}", f"  {self.equation}", f"  source: {self.source}"]
        lines += [f"  {self.acts}"]
        for each in self.parameters:
            low, high = each.bounds
            end = f"shipped as {each.value:g}" if each.off is None else f"vanishes at {each.off:g}"
            end = "set by earlier runs" if each.earlier else end
            lines.append(f"  {self.full_name(each.name)} [{each.unit}]: {each.doc}")
            lines.append(f"    {low:g} to {high:g}, {end}")
        return "\n".join(lines)


def joined(present: Sequence[Effect], added: Iterable[Effect]) -> tuple[Effect, ...]:
    """Return the effects of a model and those added; one that is in it already stays as it is.

    Raises BadInput where two added effects have one name: their parameters would clash.
    """
    known = {each.name for each in present}
    fresh = [each for each in added if each.name not in known]
    for number, each in enumerate(fresh):
        if each.name in (other.name for other in fresh[:number]):
            raise BadInput(f'two effects have the name "{each.name}": rename one of them')
    return (*present, *fresh)
