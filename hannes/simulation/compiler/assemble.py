"""From a plant's written equations and a list of effects to compiled entry points.

The equations stay the text they are: names of slots become subscripts, statements that open
channels give way to the calls of effects, and lines that only fill outputs are dropped from the
version that the integrator runs.
"""

import ast
import functools
import importlib
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from types import ModuleType
from typing import Any, Self

import numpy as np

from hannes.core import former_names
from hannes.core.effect import Effect
from hannes.core.errors import BadInput
from hannes.core.kernels.pointers import address
from hannes.core.layout import Layout, Slot
from hannes.core.parameter import Parameter
from hannes.simulation.compiler import (
    dense_jacobian,
    grasp_loop,
    implicit_steps,
    module_cache,
    workspace,
)
from hannes.simulation.compiler import entry_points as entries
from hannes.simulation.compiler import output_entry as observed
from hannes.simulation.compiler.autodiff.rules import LANES
from hannes.simulation.compiler.definite_assignment import assigned_channels
from hannes.simulation.compiler.expansion import (
    Layouts,
    opened,
    output_read_back,
    without_outputs,
)
from hannes.simulation.compiler.lanes import single
from hannes.simulation.compiler.output_slice import ProgramSlice, guarded
from hannes.simulation.compiler.own_names import require_own_names
from hannes.simulation.rodas import source as method
from hannes.simulation.rodas.linear_algebra import copy_to
from hannes.simulation.rodas.problem import Problem


@dataclass(frozen=True)
class Shape:
    """How a plant's Jacobian is differenced and solved.

    `modules` hold the text; `constants` its constants; `written` further text; `broken` says why
    the shape does not hold with these effects, or nothing; `fields` are its arrays in the
    workspace (workspace.py).
    """

    modules: tuple[ModuleType, ...]
    constants: dict[str, str]
    written: str
    broken: str
    fields: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """A plant's written equations: the module that holds them and what its slots mean.

    `entries` is the text of further entry points of its own, like entry_points.py; `memory`: how
    many numbers its firmware holds from tick to tick. `numbers`: local variables of its stages
    that effects may read; what is not declared there is no interface.
    `shape(layouts, source, names, stage_of)` finds the Shape of a plant that has one.
    """

    module: ModuleType
    parameters: Layout
    states: Layout
    channels: Layout
    outputs: Layout
    entries: str = ""
    memory: int = 10
    shape: Callable[..., Shape] | None = None
    numbers: Layout = field(default_factory=lambda: Layout(()))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Equations):
            return NotImplemented
        return self is other or all(getattr(self, f.name) == getattr(other, f.name)
                                    for f in fields(self))  # fmt: skip

    def __hash__(self) -> int:
        return hash((self.module.__name__, self.entries))

    def __repr__(self) -> str:
        return f"Equations({self.module.__name__}, {len(self.states.slots)} states)"

    def __reduce__(self) -> tuple[Any, ...]:
        rest = tuple(getattr(self, each.name) for each in fields(self)[1:])
        return _with_module, (self.module.__name__, rest)

    @classmethod
    def of(
        cls,
        module: ModuleType,
        parameters: Iterable[Parameter],
        *,
        states: Iterable[Slot] = (),
        channels: Iterable[Slot] = (),
        outputs: Iterable[Slot] = (),
        numbers: Iterable[Slot] = (),
        entries: str = "",
    ) -> Self:
        """Equations from plain lists: parameters as declared, and slots by what they are.

        Without `entries` of its own a plant runs by implicit_steps.py.
        """
        packed = (Slot(each.name.replace(".", "_"), each.unit, each.doc) for each in parameters)
        p, y, c, out, read = (
            Layout(tuple(each)) for each in (packed, states, channels, outputs, numbers)
        )
        return cls(module, p, y, c, out, entries or _functions(implicit_steps), numbers=read)

    def source(self) -> str:
        """Text of the module's functions, without its imports and head."""
        return former_names.opened(_functions(self.module))

    def stage_of(self, channel: str) -> str:
        """Name of the written function in which effects may add to `channel`."""
        stage = ""
        for line in self.source().splitlines():
            if line.startswith("def "):
                stage = line[4 : line.index("(")]
            if (opening := opened(line)) and channel in opening[1]:
                return stage
        return ""

    def accepts(self, effect: Effect) -> str:
        """Return why this plant cannot carry `effect`, or an empty string where it can."""
        for term in effect.terms:
            for channel in term.writes:
                if not self.stage_of(channel):
                    return f"it needs a channel {channel}, which this plant does not have"
                here = self.channels.slot(channel).unit
                if term.unit not in ("", here):
                    return f"it adds {term.unit} to {channel}, which this plant has in {here}"
            for name in term.arguments:
                if why := self._unreadable(name, effect, term.writes[0]):
                    return f"it reads {name}, which {why}"
        return ""

    def _unreadable(self, name: str, effect: Effect, channel: str) -> str:
        """Why a kernel that adds to `channel` cannot read `name`, or nothing."""
        own = {each.name for each in effect.parameters} | {each.name for each in effect.states}
        if name in own or name == "t" or name in self.parameters or name in self.states:
            return ""
        if name in self.channels and self.channels.slot(name).axis:
            late = name not in self._assigned[channel]
            return f"is not yet assigned where {channel} is open" if late else ""
        if name in self._locals(channel):
            declared = name in self.numbers or name in self.channels
            return "" if declared else f"is a variable of {self.stage_of(channel)} alone"
        if name in self.channels:
            return f"is not at hand where {channel} is open"
        return "this plant does not have"

    @functools.cached_property
    def _assigned(self) -> dict[str, set[str]]:
        return assigned_channels(self.source(), self.channels)

    def _locals(self, channel: str) -> set[str]:
        """Names bound in the stage of `channel` before effects join."""
        stage, bound = self.stage_of(channel), set()
        function = getattr(self.module, stage)
        for line in inspect.getsource(function).splitlines():
            if (opening := opened(line)) and channel in opening[1]:
                break
            if assigned := re.match(r"^    ([\w, ]+?) (?:=|\+=) ", line):
                bound |= set(assigned[1].split(", "))
        return bound | set(inspect.signature(function).parameters)


def _with_module(name: str, rest: tuple[Any, ...]) -> Equations:
    return Equations(importlib.import_module(name), *rest)


@dataclass(frozen=True, eq=False)
class Compiled:
    """Entry points of one plant with `effects`: `fast`, by entry_points.py, and `observed`."""

    text: str
    parameters: Layout
    states: Layout
    outputs: Layout
    fast: ModuleType
    observed: ModuleType
    needed: ProgramSlice
    jacobian_kind: str = "dense differences"
    effects: tuple[Effect, ...] = ()

    def problem(self, p: np.ndarray, reference: np.ndarray, memory: np.ndarray) -> Problem:
        """The rates with these parameters as a problem for `Rodas`."""
        given = self.workspace(), p, reference, memory
        return Problem(self.fast.steps_on, self.fast.look_up, given)

    def workspace(self) -> np.ndarray:
        """An empty workspace for `steps_on` and `ticks_on`."""
        return np.zeros(1, self.fast.WORKSPACE)

    def is_warm(self, entry: str = "rates") -> bool:
        """Whether machine code of a former run can be used for an entry point."""
        return single.is_kept(getattr(self.fast, entry))


def assemble(plant: Equations, effects: Iterable[Effect] = ()) -> Compiled:
    """Compile `plant` with `effects`; the same set is assembled once per process.

    Raises BadInput where an effect does not fit the plant, or its equations read an output or have
    a function of a name that is taken.
    """
    return _assembled(plant, tuple(effects))


@functools.cache
def _assembled(plant: Equations, effects: tuple[Effect, ...]) -> Compiled:
    for effect in effects:
        if why := plant.accepts(effect):
            raise BadInput(f"effect {effect.name} does not fit: {why}")
    if name := output_read_back(plant.source()):
        raise BadInput(
            f"{plant.module.__file__}: out.{name} is read, and outputs are only filled: what fills "
            "them is dropped where the integrator runs; keep the value in a local variable"
        )
    layouts = Layouts(plant.parameters, plant.states, plant.channels, plant.outputs, effects)
    text = layouts.expanded(plant.source())
    sizes = layouts.sizes() | {"MEMORY": str(plant.memory)}
    solution, kind = _solution(plant, layouts, text)
    running = layouts.expanded("".join(map(_functions, solution.modules))) + solution.written
    running += method.source() + _functions(entries) + _functions(grasp_loop) + plant.entries
    require_own_names(plant.module, text, running + _functions(observed))
    names = _names(plant, solution.modules, effects)
    origin = module_cache.fingerprint(names)
    needed = ProgramSlice.of(text, layouts.out)
    sizes["STATEMENTS"] = str(len(needed.statements))
    seen = module_cache.module(
        "observed", guarded(text) + _functions(observed), names, origin, sizes
    )
    quick = without_outputs(text) + running
    known = vars(entries) | vars(grasp_loop)
    names |= {name: value for name, value in known.items() if name.isupper()}
    names["fill_outputs"] = seen.fill_outputs
    origin += seen.__name__
    sizes |= solution.constants
    sizes["WORKSPACE"] = workspace.text(solution.fields)
    fast = module_cache.module("fast", quick, names, origin, sizes)
    single.offered(fast, seen)
    return Compiled(text, layouts.p, layouts.y, layouts.out, fast, seen, needed, kind, effects)


def jacobian_kind(plant: Equations, effects: Iterable[Effect] = ()) -> str:
    """How the Jacobian of `plant` with `effects` is had: "structured", or what else and why."""
    chosen = tuple(effects)
    layouts = Layouts(plant.parameters, plant.states, plant.channels, plant.outputs, chosen)
    return _solution(plant, layouts, layouts.expanded(plant.source()))[1]


def _names(
    plant: Equations, solution: tuple[ModuleType, ...], effects: tuple[Effect, ...]
) -> dict[str, Any]:
    """What the written texts and the calls of effects go by."""
    kernels = {effect.kernel_name(term): term.kernel for effect in effects for term in effect.terms}
    known = {name: value for each in solution for name, value in vars(each).items()}
    return {
        **vars(plant.module), **known, **method.NAMES, **LANES, **kernels,
        "record": workspace.record, "address": address, "copy_to": copy_to,
    }  # fmt: skip


def _solution(plant: Equations, layouts: Layouts, text: str) -> tuple[Shape, str]:
    """How to difference and solve, and what to call it; `text` has the calls of effects."""
    dense = Shape((dense_jacobian,), {}, "", "", dense_jacobian.FIELDS)
    if plant.shape is None:
        return dense, "dense differences"
    names = _names(plant, (), layouts.effects)
    shape = plant.shape(layouts, without_outputs(text), names, plant.stage_of)
    if shape.broken:
        return dense, f"dense differences, because {shape.broken}"
    return shape, "structured"


@functools.cache
@functools.lru_cache(maxsize=64)
def _functions(module: ModuleType) -> str:
    """Text of a module from its first function on; read once, however often it is asked for."""
    text = inspect.getsource(module)
    first = next(node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef))
    return "\n".join(text.splitlines()[first.lineno - 1 :]) + "\n"
