"""All that hannes takes of numba's private parts; without them `njit` alone gives the same numbers.

They make compiling quicker and machine code smaller, no more. Another version of
numba may lack one: then none is used, models compile as numba does it, and one warning says so.
"""

import functools
import gc
import pkgutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba

from hannes.core.kernels import kept_code

# What is overridden or called below, as `module:attribute`.
PARTS = (
    "numba.core.caching:IndexDataCacheFile._data_name",
    "numba.core.caching:IndexDataCacheFile._data_path",
    "numba.core.caching:IndexDataCacheFile._dump",
    "numba.core.caching:IndexDataCacheFile._open_for_write",
    "numba.core.codegen:JITCodeLibrary._optimize_final_module",
    "numba.core.codegen:JITCodeLibrary._finalize_final_module",
    "numba.core.codegen:JITCodeLibrary._finalize_dynamic_globals",
    "numba.core.codegen:JITCodeLibrary._verify_declare_only_symbols",
    "numba.core.codegen:JITCodeLibrary.codegen",
    "numba.core.codegen:JITCPUCodegen._library_class",
    "numba.core.codegen:JITCPUCodegen._module_pass_manager",
    "numba.core.codegen:JITCPUCodegen.set_env",
    "numba.core.compiler:CompileResult._find_referenced_environments",
    "numba.core.compiler_lock:global_compiler_lock",
    "numba.core.cpu:CPUTargetOptions._nrt",
    "numba.core.cpu:CPUTargetOptions.forceinline",
    "numba.core.cpu:CPUTargetOptions.no_cfunc_wrapper",
    "numba.core.cpu:CPUTargetOptions.no_cpython_wrapper",
    "numba.core.registry:cpu_target.target_context.codegen",
    "numba:config.OPT",
)
# What code generators and libraries of code have once they are made.
OF_GENERATOR = ("_opt_level",)
OF_LIBRARY = ("_codegen", "_final_module", "_finalized")

LEVEL = 2  # of LLVM, at most
WRAPPED = "_ZN7cpython"  # how numba's names of what Python calls begin


@functools.cache
def missing() -> str:
    """Name the first private part that this numba lacks, "" where all are there; warns once."""
    found = _missing()
    if found:
        warnings.warn(
            f"numba {numba.__version__} has no {found}: models take longer to compile, "
            "their numbers are the same; a version of numba that hannes was tested with has it",
            RuntimeWarning,
            stacklevel=2,
        )
    return found


def _missing() -> str:
    for part in PARTS:
        try:
            pkgutil.resolve_name(part)
        except (ImportError, AttributeError):
            return part
    generator = _generator()
    library = generator.create_library("probe")
    for owner, names in ((generator, OF_GENERATOR), (library, OF_LIBRARY)):
        if lacking := [name for name in names if not hasattr(owner, name)]:
            return f"{type(owner).__name__}.{lacking[0]}"
    return ""


def options(**asked: Any) -> dict[str, Any]:
    """Options of `njit` that its documentation does not promise: as asked, or none."""
    return {} if missing() else asked


def compiled(dispatcher: Any, method: Callable[..., Any], signature: Any) -> Any:
    """Compile at LLVM's second level: a quarter less time than the third, and code as quick.

    As measured on the hand (docs), as is what `_library` saves, and what it saves not to
    look for garbage meanwhile, of which compiling leaves little. Under numba's own lock, for its
    level and its libraries are global.
    """
    if missing():
        return method(signature)
    lock = pkgutil.resolve_name("numba.core.compiler_lock:global_compiler_lock")
    kept_code.checked(dispatcher)
    with lock, kept_code.one_process(dispatcher), no_collection():
        level, generator = numba.config.OPT, _generator()
        library = generator._library_class
        numba.config.OPT = type(level)(min(int(level), LEVEL))
        generator._library_class = _library()
        try:
            made = method(signature)
        finally:
            numba.config.OPT, generator._library_class = level, library
        for each in dispatcher.overloads.values():
            for environment in each._find_referenced_environments():
                generator.set_env(environment.env_name, environment)
        return made


def _generator() -> Any:
    return pkgutil.resolve_name("numba.core.registry:cpu_target").target_context.codegen()


@contextmanager
def no_collection() -> Iterator[None]:
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
        """An environment's place is known by machine code."""


@functools.cache
def _library() -> type[Any]:
    """The class below, made when numba is known to have what it overrides."""
    from numba.core.codegen import JITCodeLibrary

    class Library(JITCodeLibrary):
        """Code of one function, which becomes machine code only where Python calls it.

        What only compiled code calls is linked into its callers and made better there. Numba else
        does so in each function, and again in all that call it; and of two machine codes of a
        function, one alone and one in its caller, either may run.
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
                loop_vectorize=False,
                slp_vectorize=False,
                opt=self._codegen._opt_level,
                cost="cheap",
            )
            manager.run(self._final_module, builder)

        def _finalize_final_module(self) -> None:
            if self._called:
                super()._finalize_final_module()
                return
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = True

    return Library
