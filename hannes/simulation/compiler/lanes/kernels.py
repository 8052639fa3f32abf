"""The steps and outputs of a model for several grasps at once."""

import ast
import ctypes
import functools
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from llvmlite import ir

from hannes.core.kernels.pointers import numbers_at
from hannes.simulation.compiler.assemble import Compiled
from hannes.simulation.compiler.lanes import machine, values
from hannes.simulation.compiler.lanes.emitter import Emitter
from hannes.simulation.compiler.lanes.texts import ODD, by_name, functions_of, own_digest
from hannes.simulation.compiler.lanes.values import POINTER, Field, NotInLanes, Text
from hannes.simulation.compiler.lanes.ways import HEAVY, weight
from hannes.simulation.rodas import lockstep, own_steps

LINE = 64  # bytes, of a cache line, at whose beginning each array lies
UNUSED = ("pieces", "ends", "turn", "ahead", "everything")
_SAMPLES = """
def in_samples(data, times, rows, kept, first, last):
    for k in range(first, last):
        data.out[:] = 0.0
        reference = numbers_at(data.reference[0], (data.reference[1], data.reference[2]))
        equations(
            times[k], rows[k], data.dy, data.p, data.c, reference, data.memory, data.out, {needed}
        )
{kept}
    return last
"""


_AT, _WHOLE, _REAL = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_STEPS = {  # what the functions take that take steps
    "in_step": (_AT, _WHOLE, _REAL, _AT, _AT, _WHOLE, _WHOLE, _AT, _WHOLE, _WHOLE, _AT),
    "own_steps": (_AT, _WHOLE, _REAL, _AT, _AT, _WHOLE, _AT, _WHOLE, _WHOLE, _AT),
}


class Kernels:
    """Of one model, for `width` lanes; `columns` among outputs, then states, are sampled.

    `entry`: "in_step" where all go by the steps of another grasp, "own_steps" by their own.
    """

    def __init__(self, compiled: Compiled, columns: Sequence[int], width: int, entry: str) -> None:
        self.compiled, self.columns, self.width = compiled, tuple(map(int, columns)), width
        self.entry = entry
        self.fields, self.size = _layout(compiled.fast, width)
        # Where each goes by its own steps, samples of one grasp stand side by side.
        self.alone = _layout(compiled.fast, width, ("p", "p_over"))
        steps, samples = _origins(compiled, self.columns, width, entry)
        self._steps = machine.loaded(steps, self._written_steps)
        self.steps = self._steps.function(entry, _STEPS[entry])
        self._samples = machine.loaded(samples, self._written_samples)
        given = (_AT, _AT, _AT, _AT, _WHOLE, _WHOLE)
        self.in_samples = self._samples.function("in_samples", given)

    @functools.cached_property
    def switches(self) -> tuple[int, ...]:
        """Parameters of the plant that say which stages run: the same in all lanes."""
        found = {k for text in self._texts_of_steps().values() for k in _switches(text.tree)}
        own = sum(len(effect.parameters) for effect in self.compiled.effects)
        return tuple(sorted(k for k in found if k < self.compiled.parameters.size - own))

    def _texts_of_steps(self) -> dict[str, Text]:
        own = functions_of(lockstep) + functions_of(own_steps)
        fast, own = self.compiled.fast, re.sub(r"\bproblem(\.|, )", "", own)
        names = vars(fast) | vars(lockstep) | vars(own_steps) | {"WIDTH": self.width}
        return by_name(Path(str(fast.__file__)).read_text() + own, names)

    def _texts_of_samples(self) -> dict[str, Text]:
        seen, outputs = self.compiled.observed, self.compiled.outputs.size
        kept = [
            f"    kept[k, {n}] = "
            + (f"data.out[{k}]" if k < outputs else f"rows[k, {k - outputs}]")
            for n, k in enumerate(self.columns)
        ]
        needed = tuple(bool(each) for each in self.compiled.needed.by(self.columns))
        own = _SAMPLES.format(needed=needed, kept="\n".join(f"    {each}" for each in kept))
        names = {**vars(seen), "numbers_at": numbers_at}
        return by_name(Path(str(seen.__file__)).read_text() + own, names)

    def _written_steps(self) -> ir.Module:
        states, whole, some = self.compiled.states.size, _number("whole"), _array(None)
        rows = _array(1, states, lanes=True)
        keys = {
            "in_step": [_array(1), whole, whole, some, whole, rows],
            "own_steps": [some, _array(None, lanes=True), whole, rows],
        }[self.entry]
        keys = [self._record(), whole, _number("real"), _array(states), *keys]
        return self._write(self._texts_of_steps(), self.entry, keys)

    def _written_samples(self) -> ir.Module:
        own = self.entry == "own_steps"
        rows = _array(1, self.compiled.states.size, lanes=True)
        kept, whole = _array(1, len(self.columns), lanes=True), _number("whole")
        record = ("record", tuple(self.alone[0].items())) if own else self._record()
        keys = [record, _array(1, lanes=own), rows, kept, whole, whole]
        return self._write(self._texts_of_samples(), "in_samples", keys)

    def _record(self) -> Any:
        return ("record", tuple(self.fields.items()))

    def _write(self, texts: Mapping[str, Text], name: str, keys: list[Any]) -> ir.Module:
        module = ir.Module()
        made = Emitter(module, self.width, texts, self.switches)
        types = [each for key in keys for each in _types(key)]
        try:
            made.written(texts[name], keys, types, name)
        except ODD as error:
            raise NotInLanes(f"{type(error).__name__}: {error}") from error
        return module

    def room(self, alone: bool = False) -> dict[str, np.ndarray]:
        """Arrays of an empty workspace by name, shape (..., width), or (...) of what is the same.

        alone: that of samples of one grasp. All lie in a row, the first at its beginning.
        """
        fields, size = self.alone if alone else (self.fields, self.size)
        room, found = aligned(size // 8), dict[str, np.ndarray]()
        for name, (offset, shape, kind, lanes) in fields.items():
            shape = (*shape, self.width) if lanes else shape
            part = room[offset // 8 : offset // 8 + int(np.prod(shape))]
            found[name] = (part if kind == "real" else part.view(np.int64)).reshape(shape)
        return found


def is_kept(compiled: Compiled, columns: tuple[int, ...], width: int, entry: str) -> bool:
    """Whether the steps' machine code, which takes long to make, is on disk."""
    return machine.is_kept(_origins(compiled, columns, width, entry)[0])


def _origins(
    compiled: Compiled, columns: tuple[int, ...], width: int, entry: str
) -> tuple[str, str]:
    """What makes the code of steps and of samples what it is."""
    model = compiled.fast.__name__, own_digest(), width
    return repr((*model, entry)), repr((*model, entry, compiled.observed.__name__, columns))


def aligned(size: int) -> np.ndarray:
    """Zeros from the beginning of a cache line on."""
    whole = np.zeros(size + LINE // 8)
    start = -whole.ctypes.data % LINE // 8
    return whole[start : start + size]


def _number(kind: str, known: float | None = None) -> Any:
    return ("number", kind, False, known)


def _array(*sizes: int | None, lanes: bool = False) -> Any:
    """An array in C order, of which one size may not be known."""
    strides, step = list[Any](), 1
    for size in reversed(sizes):
        strides.insert(0, _number("whole", step if step else None))
        step *= size or 0
    return ("array", tuple(_number("whole", n) for n in sizes), tuple(strides), "real", lanes, 0)


def _types(key: Any) -> list[ir.Type]:
    match key:
        case ("number", kind, _, known):
            return [] if known is not None else [values.TYPES[kind]]
        case ("array", shape, strides, *_):
            return [POINTER, *(t for part in (*shape, *strides) for t in _types(part))]
    return [POINTER]


def _layout(fast: ModuleType, width: int, same: Sequence[str] = ()) -> tuple[dict[str, Field], int]:
    """Fields of the workspace, and its bytes; `same`: what is one number for all lanes."""
    known = {name: fast.WORKSPACE.fields[name][0] for name in fast.WORKSPACE.names}
    states, parameters = fast.STATES, fast.PARAMETERS
    shapes = {n: (each.shape, each.base.kind) for n, each in known.items() if n not in UNUSED}
    shapes |= {"state": ((1, states), "f"), "piece": ((3, states), "f"), "error": ((1,), "f")}
    shapes |= {"alive": ((1,), "f"), "p_over": ((parameters,), "f"), "failed": ((1,), "f")}
    shapes |= {
        "counts": ((5,), "f"),
        "tries": ((3,), "f"),
        "place": ((2,), "f"),
        "begins": ((1,), "f"),
    }
    fields, at = dict[str, Field](), 0
    for name, (shape, kind) in shapes.items():
        lanes = kind == "f" and name not in same
        fields[name] = (at, shape, "real" if kind == "f" else "whole", lanes)
        at += -(-8 * int(np.prod(shape)) * (width if lanes else 1) // LINE) * LINE
    return fields, at


def _switches(tree: ast.AST) -> set[int]:
    """Places of parameters that heavy statements wait for."""
    return {
        part.slice.value
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and max(weight(node.body), weight(node.orelse)) > HEAVY
        for part in ast.walk(node.test)
        if isinstance(part, ast.Subscript) and ast.unparse(part.value) == "p"
        if isinstance(part.slice, ast.Constant) and isinstance(part.slice.value, int)
    }
