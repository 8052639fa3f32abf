"""The only place that imports numba: what a kernel is, and where its machine code is kept.

Machine code is cached under digests of every source that enters it, because numba itself watches
only the file of the outermost function and would run stale code after an edit of an inner one.
"""

import functools
import gc
import hashlib
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.extending import lower_builtin, type_callable

from hannes.core.io.cache import cache_home

# Options of all compiled code, and of what only compiled code calls.
_COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
_WITHIN = _COMMON | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

WRAPPED = "_ZN7cpython"  # how numba's names of what Python calls begin


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
    return numba.njit(**_COMMON, forceinline=True, _nrt=True)(function)


def inner(function: Callable[..., Any]) -> Any:
    """Compile a formula into its callers; cannot be called from Python, which halves its cost.

    Nor may it allocate: it does not count references to arrays, as each count takes a lock.
    """
    return numba.njit(**_WITHIN, forceinline=True, _nrt=False)(function)


def routine(function: Callable[..., Any]) -> Any:
    """Like `inner` for a function that stays one, long and called from several places."""
    return numba.njit(**_WITHIN, _nrt=False)(function)


def provider(function: Callable[..., Any]) -> Any:
    """Like `routine` for a function that allocates."""
    return numba.njit(**_WITHIN, _nrt=True)(function)


def folded(function: Callable[..., Any]) -> Any:
    """Like `inner`, put into its caller before types are known: cheap where there is only one."""
    return numba.njit(**_WITHIN, inline="always")(function)


def entry(function: Callable[..., Any]) -> Any:
    """Compile an entry point with all that it calls, and keep its machine code on disk."""
    dispatcher = numba.njit(**_COMMON, cache=True)(function)
    if compiles():
        dispatcher.compile = functools.partial(_compiled, dispatcher, dispatcher.compile)
    return dispatcher


def _compiled(dispatcher: Any, method: Callable[..., Any], signature: Any) -> Any:
    """Compile at LLVM's second level: a quarter less time than the third, and code as quick.

    As measured on the hand (docs/speed.md), as is what `_Library` saves, and what it saves not to
    look for garbage meanwhile, of which compiling leaves little. Under numba's own lock, for its
    level and its libraries are global.
    """
    with global_compiler_lock, _no_collection():
        level, codegen = numba.config.OPT, cpu_target.target_context.codegen()
        library = codegen._library_class
        numba.config.OPT = type(level)(min(int(level), 2))
        codegen._library_class = _Library
        try:
            made = method(signature)
        finally:
            numba.config.OPT, codegen._library_class = level, library
        for each in dispatcher.overloads.values():
            for environment in each._find_referenced_environments():
                codegen.set_env(environment.env_name, environment)
        return made


@contextmanager
def _no_collection() -> Iterator[None]:
    """Garbage is not looked for inside, where it was before."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


class _Nowhere:
    """Takes the environment of a function of which no machine code is made."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """An environment's place is told by machine code."""


class _Library(JITCodeLibrary):
    """Code of one function, which becomes machine code only where Python calls it.

    What only compiled code calls is linked into its callers and made better there. Numba else does
    so in each function, and again in all that call it; and of two machine codes of a function,
    one alone and one in its caller, either may run.
    """

    _called = True

    @property
    def codegen(self) -> Any:
        return self._codegen if self._called else _Nowhere

    def _optimize_final_module(self) -> None:
        functions = self._final_module.functions
        self._called = any(
            each.name.startswith(WRAPPED) and not each.is_declaration for each in functions
        )
        if self._called:
            super()._optimize_final_module()
            return
        manager, builder = self._codegen._module_pass_manager(
            loop_vectorize=False, slp_vectorize=False, opt=self._codegen._opt_level, cost="cheap"
        )
        manager.run(self._final_module, builder)

    def _finalize_final_module(self) -> None:
        if self._called:
            super()._finalize_final_module()
            return
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


def plain(function: Any) -> Callable[..., Any]:
    """Return the Python function behind a kernel, compiled or not."""
    return getattr(function, "py_func", function)


def compiles() -> bool:
    """Tell whether kernels become machine code here (not under NUMBA_DISABLE_JIT=1)."""
    return not numba.config.DISABLE_JIT


@functools.cache
def compiler_digest() -> str:
    """Digest of what compiles: this file's options and the versions behind them.

    A generated module's own digest covers every source that it reaches (assemble.py).
    """
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for version in (numba.__version__, np.__version__, platform.python_version()):
        digest.update(version.encode())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of generated modules and their machine code."""
    return cache_home() / compiler_digest()
