"""Where numba comes in: what a kernel is, and where its machine code is kept.

The hand's own functions are compiled by `hannes/simulation/compiler/lanes`, which
reads what is said here of kernels.

Machine code is cached under digests of every source that enters it, because numba itself watches
only the file of the outermost function and would run stale code after an edit of an inner one.
"""

import functools
import hashlib
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.extending import lower_builtin, type_callable

from hannes.core.io.cache import cache_home
from hannes.core.kernels import numba_private

_COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy"}  # of all compiled code


def _within(**options: Any) -> dict[str, Any]:
    """Options of what only compiled code calls."""
    private = numba_private.options(no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)
    return _COMMON | private


def fused(a: float, b: float, c: float) -> float:
    """a b + c; compiled it is rounded once, and for all alike, in one instruction of today's CPUs.

    The compiler could do so of itself where it sees fit, which is not the same place in each
    function that a formula is compiled into: bits would differ between one grasp and many.
    """
    return a * b + c


@type_callable(fused)
def _fused_type(context: Any) -> Callable[..., Any]:
    return lambda a, b, c: numba.float64(numba.float64, numba.float64, numba.float64)


@lower_builtin(fused, numba.types.Float, numba.types.Float, numba.types.Float)
def _fused_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    return builder.fma(*given)


def power_of_two(k: float) -> float:
    """2^k for a whole k from -1022 to 1023; compiled it is made of k's own bits, without a call."""
    return float(2.0**k)


@type_callable(power_of_two)
def _power_type(context: Any) -> Callable[..., Any]:
    return lambda k: numba.float64(numba.float64)


@lower_builtin(power_of_two, numba.types.Float)
def _power_code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    """Beside 1.5 * 2^52 a whole number stands in the last bits; an exponent begins at bit 52."""
    real, whole = numba.float64, numba.int64
    beside = builder.fadd(*given, context.get_constant(real, 1.5 * 2.0**52))
    bits = builder.bitcast(beside, context.get_value_type(whole))
    raised = builder.shl(bits, context.get_constant(whole, 52))
    power = builder.add(raised, context.get_constant(whole, 1023 << 52))
    return builder.bitcast(power, context.get_value_type(real))


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a formula into its callers; runs as plain Python under NUMBA_DISABLE_JIT=1.

    It may allocate, whoever calls it: without `_nrt` it would be as its caller is (see `inner`).
    """
    return numba.njit(**_COMMON, **numba_private.options(forceinline=True, _nrt=True))(function)


def inner(function: Callable[..., Any]) -> Any:
    """Compile a formula into its callers; cannot be called from Python, which halves its cost.

    Nor may it allocate: it does not count references to arrays, as each count takes a lock.
    """
    return numba.njit(**_within(forceinline=True, _nrt=False))(function)


def routine(function: Callable[..., Any]) -> Any:
    """Like `inner` for a function that stays one, long and called from several places.

    That has to be said: numba else hands on to a function what its caller asks for itself. All of a
    model then becomes one function, which takes twice as long to compile.
    """
    return numba.njit(**_within(forceinline=False, _nrt=False))(function)


def provider(function: Callable[..., Any]) -> Any:
    """Like `routine` for a function that allocates."""
    return numba.njit(**_within(_nrt=True))(function)


def folded(function: Callable[..., Any]) -> Any:
    """Like `inner`, put into its caller before types are known: cheap where there is only one."""
    return numba.njit(**_within(), inline="always")(function)


def entry(function: Callable[..., Any]) -> Any:
    """Compile an entry point with all that it calls, and keep its machine code on disk."""
    dispatcher = numba.njit(**_COMMON, cache=True)(function)
    if compiles():
        dispatcher.compile = functools.partial(
            numba_private.compiled, dispatcher, dispatcher.compile
        )
    return dispatcher


def plain(function: Any) -> Callable[..., Any]:
    """Return the Python function behind a kernel, compiled or not."""
    return getattr(function, "py_func", function)


def compiles() -> bool:
    """Return whether kernels become machine code here (not under NUMBA_DISABLE_JIT=1)."""
    return not numba.config.DISABLE_JIT


@functools.cache
def compiler_digest() -> str:
    """Digest of what compiles: options here and in `numba_private`, and the versions behind them.

    A generated module's own digest covers every source that it reaches (assemble.py).
    """
    digest = hashlib.sha256(Path(__file__).read_bytes())
    digest.update(Path(numba_private.__file__).read_bytes())
    missing = numba_private.missing()
    for part in (numba.__version__, np.__version__, platform.python_version(), missing):
        digest.update(part.encode())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of generated modules and their machine code."""
    return cache_home() / compiler_digest()
