"""What a kernel may add to, and what it may read there: from a plant's layouts and equations."""

import ast
import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from hannes.core.effect import Effect, Term
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.simulation.compiler.assemble import Equations

_SIZE = Parameter("size", 0.0, "1", (0.0, 1.0), "of what is added", off=0.0)
_ARRAYS = {"t", "y", "dy", "p", "c", "reference", "memory", "out"}  # that stages hand each other


@dataclass(frozen=True)
class Open:
    """A channel that effects may add to, the stage that opens it, and what is known there.

    `arrays` are channels with an axis, of which a kernel along the same axis gets its element;
    `numbers` the stage's own. The time `t`, states and parameters can be read everywhere.
    """

    slot: Slot
    stage: str
    arrays: tuple[str, ...]
    numbers: tuple[str, ...]


def open_channels(equations: Equations) -> Iterator[Open]:
    """Every channel that effects may add to, in the order of the layout."""
    arrays = [slot.name for slot in equations.channels.slots if slot.axis]
    for slot in equations.channels.slots:
        if stage := equations.stage_of(slot.name):
            numbers = [name for name in _bound(equations, stage) if name not in arrays]
            known, own = (
                tuple(name for name in names if _readable(equations, name, slot.name))
                for names in (arrays, numbers)
            )
            yield Open(slot, stage, known, own)


def _bound(equations: Equations, stage: str) -> list[str]:
    """Numbers that a stage receives or computes, in the order of its text."""
    function = next(
        node
        for node in ast.parse(equations.source()).body
        if isinstance(node, ast.FunctionDef) and node.name == stage
    )
    stored = [
        node.id
        for statement in function.body
        for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    ]
    names = dict.fromkeys([*(each.arg for each in function.args.args), *stored])
    taken = {slot.name for slot in (*equations.parameters.slots, *equations.states.slots)}
    return [name for name in names if name not in taken | _ARRAYS]


def _readable(equations: Equations, name: str, channel: str) -> bool:
    kernel = _kernel_reading(name)
    term = Term(kernel, (channel,))
    return not equations.accepts(Effect("probe", "", "", "", (_SIZE,), (term,)))


def _kernel_reading(name: str) -> Callable[..., float]:
    """A kernel that takes the effect's size and one quantity."""

    def kernel(*given: float) -> float:
        return 0.0

    places = [inspect.Parameter(n, inspect.Parameter.POSITIONAL_ONLY) for n in ("size", name)]
    kernel.__signature__ = inspect.Signature(places)  # type: ignore[attr-defined]
    return kernel
