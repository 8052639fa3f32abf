"""One grasp at a time: the functions of a model that numba compiles too, in a sixth of the time.

The text is the same, and so are the numbers, to the bit. Loops over joints are left to LLVM, which
works on four at a time; what numba is kept from knowing is kept from LLVM here as well
(`hannes/core/kernels/pointers.py`).
"""

import threading
import types
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from llvmlite import ir

from hannes.core.kernels.jit import compiles, plain
from hannes.simulation.compiler.lanes import handed, machine
from hannes.simulation.compiler.lanes.emitter import Emitter
from hannes.simulation.compiler.lanes.texts import ODD, own_digest, texts_of
from hannes.simulation.compiler.lanes.values import Field, NotInLanes

# What Python calls: plain Python over functions of the same module, which are compiled.
OF_MODEL = {
    "rates": ("equations",),
    "differences": ("equations",),
    "tick": ("sample",),
    "jacobian": ("fill_jacobian",),
    "steps_on": ("step_on",),
    "ticks_on": ("tick_on",),
    "look_up": ("sample_pieces",),
    "grasps": ("reading_ages", "each_grasp"),
}
OF_OUTPUTS = {"observe": ("fill_outputs",)}
_ENTRIES: dict[str, tuple[str, ...]] = OF_MODEL | OF_OUTPUTS


class Single:
    """Machine code of modules: of a model and of its outputs, or of these alone."""

    def __init__(self, *modules: ModuleType) -> None:
        entries = (OF_MODEL, OF_OUTPUTS)[-len(modules) :]
        self.modules = {m: _called(m, each) for m, each in zip(modules, entries, strict=True)}
        self._functions: dict[str, dict[str, Callable[..., int]]] | None = None
        self._making = threading.Lock()

    def entry(self, module: ModuleType, written: Callable[..., Any]) -> Callable[..., Any] | None:
        """An entry point of a module as plain Python over machine code; None where there is none.

        Then the text has something that is not known here, and is left to numba.
        """
        with self._making:
            if self._functions is None:
                self._functions = self._made()
        made = self._functions[module.__name__]
        if not made.keys() >= set(_ENTRIES[written.__name__]):
            return None
        return types.FunctionType(written.__code__, vars(module) | made)

    def is_kept(self, entry: str = "") -> bool:
        """Whether its machine code is on disk, with all that an entry calls."""
        code = machine.kept(self._origin())
        names = _ENTRIES.get(entry, ())
        return code is not None and all(_holds(code, name) for name in names)

    def at_hand(self) -> bool:
        """Whether it is there already."""
        return self._functions is not None or self.is_kept()

    def _made(self) -> dict[str, dict[str, Callable[..., int]]]:
        """Functions by module and name."""
        try:
            loaded = machine.loaded(self._origin(), self.written, lanes=False)
        except (NotInLanes, RuntimeError, ArithmeticError):  # these two: of LLVM
            return {module.__name__: {} for module in self.modules}
        return {
            module.__name__: {
                name: handed.callable_from(loaded, plain(vars(module)[name]))
                for name in names
                if loaded.address(name)
            }
            for module, names in self.modules.items()
        }

    def _origin(self) -> str:
        return repr((*(module.__name__ for module in self.modules), own_digest(), "single"))

    def written(self) -> ir.Module:
        """All functions as instructions but those that are refused; NotInLanes where all are."""
        texts = {module.__name__: texts_of(module) for module in self.modules}
        left = [texts[m.__name__][name] for m, names in self.modules.items() for name in names]
        first = next(iter(self.modules))
        known = {
            f"{name}.{each}": text for name, own in texts.items() for each, text in own.items()
        }
        known |= texts[first.__name__]
        record = _fields(first.WORKSPACE) if len(texts) > 1 else {}
        while left:
            made = Emitter(ir.Module(), 1, known)
            for text in left:
                try:
                    handed.write(made, text, record)
                except (NotInLanes, *ODD):
                    left.remove(text)
                    break
            else:
                return made.module
        raise NotInLanes("no function")


def _holds(code: bytes, name: str) -> bool:
    """Whether a function is among the names of machine code, which some systems begin with _."""
    return any(f"\0{each}\0".encode() in code for each in (name, f"_{name}"))


def _called(module: ModuleType, entries: Mapping[str, Iterable[str]]) -> list[str]:
    """Functions of a module that its entries call."""
    names = dict.fromkeys(name for needed in entries.values() for name in needed)
    return [name for name in names if vars(module).get(name) is not None]


def _fields(kind: Any) -> dict[str, Field]:
    """Fields of a workspace as numpy has it."""
    parts = {name: kind.fields[name][:2] for name in kind.names}
    return {
        name: (at, part.shape, "whole" if part.base.kind == "i" else "real", False)
        for name, (part, at) in parts.items()
    }


class Entry:
    """A function that Python calls; which code runs is found when it is first called.

    That of `single` where it is there, else that of `alone`, which has no more than is needed.
    """

    def __init__(self, single: Single, alone: Single, module: ModuleType, by_numba: Any) -> None:
        self.single, self.alone, self.module, self.by_numba = single, alone, module, by_numba
        self.py_func, self.run = by_numba.py_func, self._first
        self.__name__, self.__doc__ = self.py_func.__name__, self.py_func.__doc__

    def __call__(self, *given: Any) -> Any:
        """Run it."""
        return self.run(*given)

    def _first(self, *given: Any) -> Any:
        single = self.single if self.single.at_hand() else self.alone
        numba_has_it = self.is_numba_s() and not single.is_kept(self.__name__)
        made = None if numba_has_it else single.entry(self.module, self.py_func)
        self.run = made or self.by_numba
        return self.run(*given)

    def is_numba_s(self) -> bool:
        """Whether numba has compiled it in a former run, as it was refused here."""
        own = Path(str(self.module.__file__))
        return any((own.parent / "__pycache__").glob(f"{own.stem}.{self.__name__}-*.nbi"))

    def is_kept(self) -> bool:
        """Whether machine code of a former run can be used."""
        return self.single.is_kept(self.__name__) or self.is_numba_s()


def offered(fast: ModuleType, seen: ModuleType) -> None:
    """Put this code in the place of numba's for what Python calls of a model's two modules."""
    if not compiles():
        return
    single, outputs = Single(fast, seen), Single(seen)
    for module, names, alone in ((fast, OF_MODEL, single), (seen, OF_OUTPUTS, outputs)):
        for name in names:
            setattr(module, name, Entry(single, alone, module, getattr(module, name)))


def is_kept(function: Any) -> bool:
    """Whether machine code of a former run can be used for what Python calls."""
    return isinstance(function, Entry) and function.is_kept()
