"""Arrays handed from function to function as one word each.

Numba hands an array on as seven words or more, which a call that is not inlined copies from stack
to stack. A function that knows the shape can do with the address of the first element. The arrays
made of an address hold no reference: whoever hands one on keeps the array alive.
"""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.extending import lower_builtin, type_callable


def pointer(array: np.ndarray) -> np.ndarray:
    """Address of the first element of an array in C order; plain Python hands on the array."""
    return array


def shaped(place: Any, shape: tuple[int, ...]) -> Any:
    """The array of this shape behind a `pointer`; plain Python returns the array itself.

    The compiler knows nothing of where it lies: of arrays at known distances from each other, as in
    one record, it works on fewer elements at a time, or on one, lest a store is read before it is
    through.
    """
    return place


def unknown(size: int) -> int:
    """The same size, of which the compiler knows nothing.

    A loop of a known number of turns it may write out, turn by turn; of an unknown one it makes a
    loop that works on several elements at a time.
    """
    return size


def address(array: np.ndarray) -> int:
    """Address of the first element as a whole number, to be kept in a record."""
    return int(array.ctypes.data)


def numbers_at(place: int, shape: tuple[int, ...]) -> np.ndarray:
    """Array of numbers (float64) at an `address`."""
    pointed = ctypes.cast(int(place), ctypes.POINTER(ctypes.c_double))
    return np.ctypeslib.as_array(pointed, shape)


def _is_plain(array: Any) -> bool:
    return isinstance(array, numba.types.Array) and array.layout == "C"


@type_callable(pointer)
def _pointer_type(context: Any) -> Callable[..., Any]:
    return lambda array: numba.types.CPointer(array.dtype) if _is_plain(array) else None


@lower_builtin(pointer, numba.types.Array)
def _pointer_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    return context.make_array(signature.args[0])(context, builder, *given).data


@type_callable(address)
def _address_type(context: Any) -> Callable[..., Any]:
    return lambda array: numba.int64 if _is_plain(array) else None


@lower_builtin(address, numba.types.Array)
def _address_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    data = context.make_array(signature.args[0])(context, builder, *given).data
    return builder.ptrtoint(data, context.get_value_type(numba.int64))


@type_callable(shaped)
def _shaped_type(context: Any) -> Callable[..., Any]:
    return lambda place, shape: numba.types.Array(place.dtype, len(shape), "C")


@lower_builtin(shaped, numba.types.CPointer, numba.types.BaseTuple)
def _shaped_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    sizes = _sizes(context, builder, signature, given)
    place = _hidden(builder, given[0])
    return _array(context, builder, signature.return_type, place, sizes)


def _hidden(builder: Any, value: Any) -> Any:
    """The same value, through an instruction of which the compiler knows nothing."""
    kind = ir.FunctionType(value.type, [value.type])
    return builder.asm(kind, "", "=r,0", [value], False)


@type_callable(unknown)
def _unknown_type(context: Any) -> Callable[..., Any]:
    return lambda size: numba.intp


@lower_builtin(unknown, numba.types.Integer)
def _unknown_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    size = context.cast(builder, given[0], signature.args[0], numba.intp)
    return _hidden(builder, size)


@type_callable(numbers_at)
def _numbers_type(context: Any) -> Callable[..., Any]:
    return lambda place, shape: numba.types.Array(numba.float64, len(shape), "C")


@lower_builtin(numbers_at, numba.types.Integer, numba.types.BaseTuple)
def _numbers_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    kind = context.get_value_type(numba.types.CPointer(numba.float64))
    data = builder.inttoptr(given[0], kind)
    sizes = _sizes(context, builder, signature, given)
    return _array(context, builder, signature.return_type, data, sizes)


def _sizes(context: Any, builder: Any, signature: Any, given: Any) -> list[Any]:
    """Elements of the shape as whole numbers of a word."""
    return [
        context.cast(builder, builder.extract_value(given[1], n), each, numba.intp)
        for n, each in enumerate(signature.args[1])
    ]


def _array(context: Any, builder: Any, kind: Any, data: Any, sizes: Sequence[Any]) -> Any:
    """The parts of an array in C order that has no owner."""
    word = context.get_value_type(numba.intp)
    width = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    made = context.make_array(kind)(context, builder)
    made.data, made.itemsize = data, word(width)
    strides, step = list[Any](), word(width)
    for size in reversed(sizes):
        strides.insert(0, step)
        step = builder.mul(step, size, flags=["nsw"])
    made.nitems = builder.udiv(step, word(width))
    for name, parts in (("shape", sizes), ("strides", strides)):
        held = getattr(made, name)
        for n, part in enumerate(parts):
            held = builder.insert_value(held, part, n)
        setattr(made, name, held)
    made.meminfo, made.parent = made.meminfo.type(None), made.parent.type(None)
    return made._getvalue()
