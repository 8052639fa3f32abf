"""What Python hands to machine code: numbers, and arrays of numpy by the addresses of these."""

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from llvmlite import ir

from hannes.simulation.compiler.lanes.emitter import Emitter
from hannes.simulation.compiler.lanes.loops import State
from hannes.simulation.compiler.lanes.machine import Loaded
from hannes.simulation.compiler.lanes.values import POINTER, TYPES, Field, Number, Record, Text

Kind = tuple[str, int]  # of a number, and how many dimensions its array has; 0 for a single one

_LISTS: dict[Kind, str] = {
    ("real", 0): "t rtol",
    ("whole", 0): "first",
    ("record", 1): "room",
    ("real", 1): "y dy p c memory out atol clock bounds ends times periods ages none path",
    ("real", 2): "reference work vectors starts outputs late rows memories states",
    ("real", 3): "pieces kept",
    ("whole", 1): "columns",
    ("whole", 2): "counts",
    ("byte", 1): "stop needed",
}
KINDS = {name: kind for kind, names in _LISTS.items() for name in names.split()}
_OTHER: dict[str, dict[str, Kind]] = {  # where a function has another kind by that name
    "fill_jacobian": {"columns": ("real", 2)},
    "step_on": {"counts": ("whole", 1)},
    "tick_on": {"counts": ("whole", 1)},
}
_DTYPES = {"real": np.dtype(np.float64), "whole": np.dtype(np.int64), "byte": np.dtype(np.bool_)}
# What gives the value of Python's numbers, and of what can be made one.
_NUMBERS = {"real": "PyFloat_AsDouble", "whole": "PyLong_AsLongLong"}
_POINTER = ctypes.sizeof(ctypes.c_void_p)
# How Python calls a function that takes its objects in a row (METH_FASTCALL): with what belongs to
# the function, here numpy's class of arrays, the objects, and their count.
_CALLED, _FASTCALL = ir.FunctionType(POINTER, [POINTER, POINTER, TYPES["whole"]]), 0x80
_NEW = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
    ("PyCFunction_NewEx", ctypes.pythonapi)
)
# Of an array as numpy's headers have it (PyArrayObject), bytes after what all objects have: its
# data, count of dimensions, shape, type (PyArray_Descr: kind, letter, order of bytes), flags.
_AT = object.__basicsize__
_OWN_TYPE, _COUNT, _SIZES, _DTYPE, _FLAGS = _AT - 8, _AT + 8, _AT + 16, _AT + 40, _AT + 48
_SOUND = 0x101  # of its flags: in C order, aligned
_REFUSED = -(2**63)  # where an array is not as expected
_METHODS: list["_Method"] = []  # Python holds their addresses as long as the process lives


def kinds(name: str, arguments: Iterable[str]) -> list[Kind]:
    """What a function takes; KeyError where that is not known."""
    own = _OTHER.get(name, {})
    return [own.get(each) or KINDS[each] for each in arguments]


def write(made: Emitter, text: Text, record: Mapping[str, Field]) -> None:
    """Write a function that Python can call; it runs without the interpreter's lock.

    It returns a whole number: its own, 0 where it has none, or that it refused what it was given.
    """
    taken, build = kinds(text.tree.name, (each.arg for each in text.tree.args.args)), made.builder
    function = ir.Function(made.module, _CALLED, text.tree.name)
    made.state = State(function)
    of_numpy, objects, count = function.args
    begin, refused = made.new_block(), made.new_block()
    build.position_at_end(refused)
    build.ret(_python(made, "PyLong_FromLongLong", POINTER, TYPES["whole"](_REFUSED)))
    build.position_at_end(begin)
    _unless(made, build.icmp_unsigned("!=", count, count.type(len(taken))), refused)
    given = [_word(made, objects, _POINTER * k, POINTER) for k in range(len(taken))]
    arrays = [(each, kind) for each, kind in zip(given, taken, strict=True) if kind[1]]
    for each, _ in arrays:
        own = _word(made, each, _OWN_TYPE, POINTER)
        _unless(made, build.icmp_unsigned("!=", own, of_numpy), refused)
    for each, kind in arrays:
        _unless(made, _is_other(made, each, kind), refused)
    values = [_value(made, *each, record) for each in zip(given, taken, strict=True)]
    _unless_raised(made)
    thread = _python(made, "PyEval_SaveThread", POINTER)
    found = made.inline(text, values)
    found = made.as_kind(found if isinstance(found, Number) else made.known(0), "whole")
    _python(made, "PyEval_RestoreThread", ir.VoidType(), thread)
    build.ret(_python(made, "PyLong_FromLongLong", POINTER, found.ir))


def _unless(made: Emitter, wrong: ir.Value, then: ir.Block) -> None:
    """Go on where nothing is wrong."""
    after = made.new_block()
    made.builder.cbranch(wrong, then, after)
    made.builder.position_at_end(after)


def _unless_raised(made: Emitter) -> None:
    """Go on where Python has raised nothing."""
    here, raised, none = made.builder.block, made.new_block(), ir.Constant(POINTER, None)
    made.builder.position_at_end(raised)
    made.builder.ret(none)
    made.builder.position_at_end(here)
    error = _python(made, "PyErr_Occurred", POINTER)
    _unless(made, made.builder.icmp_unsigned("!=", error, none), raised)


def _python(made: Emitter, name: str, result: ir.Type, *given: ir.Value) -> ir.Value:
    """A call of Python's own."""
    return made.builder.call(made.declared(name, result, [each.type for each in given]), given)


def _is_other(made: Emitter, given: ir.Value, kind: Kind) -> ir.Value:
    """Whether an array is not as expected."""
    build, half, dtype = made.builder, ir.IntType(32), _DTYPES.get(kind[0])
    flags = build.and_(_word(made, given, _FLAGS, half), half(_SOUND))
    found = build.icmp_unsigned("!=", flags, half(_SOUND))
    count = build.icmp_unsigned("!=", _word(made, given, _COUNT, half), half(kind[1]))
    found = build.or_(found, count)
    if dtype is not None:
        letters = _word(made, _word(made, given, _DTYPE, POINTER), _AT + 8, ir.IntType(24))
        wanted = int.from_bytes(f"{dtype.kind}{dtype.char}{dtype.byteorder}".encode(), "little")
        found = build.or_(found, build.icmp_unsigned("!=", letters, letters.type(wanted)))
    return found


def _value(made: Emitter, given: ir.Value, kind: Kind, record: Mapping[str, Field]) -> Any:
    of, dimensions = kind
    if dimensions == 0:
        return Number(_python(made, _NUMBERS[of], TYPES[of], given), of)
    at = _word(made, given, _AT, POINTER)
    if of == "record":
        return Record(at, record)
    sizes = _word(made, given, _SIZES, POINTER)
    shape = [Number(_word(made, sizes, 8 * k, TYPES["whole"]), "whole") for k in range(dimensions)]
    return made.rows(at, shape, of, False)


def _word(made: Emitter, at: ir.Value, offset: int, kind: ir.Type) -> ir.Value:
    place = made.builder.gep(at, [ir.Constant(TYPES["whole"], offset)], source_etype=ir.IntType(8))
    return made.builder.load(place, typ=kind)


class _Method(ctypes.Structure):
    """Of a function that Python can call (PyMethodDef)."""

    _fields_ = (
        ("name", ctypes.c_char_p), ("code", ctypes.c_void_p), ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )  # fmt: skip


def callable_from(loaded: Loaded, written: Callable[..., Any]) -> Callable[..., int]:
    """The compiled one of a function, which takes numbers and arrays.

    Arrays of another type, or not in C order, are copied, and copied back where they can be
    written to. Raises TypeError for what is no array of so many dimensions.
    """
    name, code = written.__name__, written.__code__
    taken = kinds(name, code.co_varnames[: code.co_argcount])
    method = _Method(name.encode(), loaded.address(name), _FASTCALL, None)
    called = _NEW(ctypes.byref(method), np.ndarray, None)

    def run(*given: Any) -> int:
        found: int = called(*given)
        return found if found != _REFUSED else copied(given)

    def copied(given: Sequence[Any]) -> int:
        handed = list(given)
        for n, (each, (kind, dimensions)) in enumerate(zip(given, taken, strict=True)):
            if dimensions == 0:
                continue
            if not isinstance(each, np.ndarray) or each.ndim != dimensions:
                raise TypeError(f"{name}: expected an array of {dimensions} dimensions, {each!r}")
            handed[n] = np.require(each, _DTYPES.get(kind, each.dtype), ("C", "A"))
        found: int = called(*map(np.asarray, handed))
        if found == _REFUSED:
            raise TypeError(f"{name}: expected plain arrays of numbers")
        for each, copy in zip(given, handed, strict=True):
            if copy is not each and each.flags.writeable:
                each[...] = copy
        return found

    _METHODS.append(method)
    return run
