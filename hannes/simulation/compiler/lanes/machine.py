"""Instructions to machine code: for how many lanes, optimised, kept on disk."""

import ctypes
import functools
import hashlib
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numba
from llvmlite import ir

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import write_bytes
from hannes.core.io.locks import alone
from hannes.core.kernels import numba_private
from hannes.core.kernels.jit import cache_folder, compiles
from hannes.core.kernels.kept_code import warn_not_kept

_WIDE = ('"prefer-vector-width"="512"', '"min-legal-vector-width"="512"', '"stackrealign"')
_WIDTHS = (("avx512f", 8), ("avx2", 4), ("avx", 4), ("sse2", 2), ("neon", 2))


@functools.cache
def width() -> int:
    """How many grasps go side by side on this processor; HANNES_LANES says otherwise."""
    asked = os.environ.get("HANNES_LANES", "")
    if asked not in ("", "1", "2", "4", "8"):
        raise BadInput(f"HANNES_LANES = {asked}: expected 1, 2, 4 or 8")
    if not compiles():
        return 1
    features = llvm.get_host_cpu_features()
    fuses = features.get("fma") or features.get("neon")  # else a quotient calls the library
    own = next((lanes for name, lanes in _WIDTHS if fuses and features.get(name)), 1)
    return int(asked) if asked else own


def _target() -> Any:
    """What machine code is made for; whoever loads code owns it."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=_made_for()[0],
        features=_made_for()[1],
        opt=_made_for()[2],
        reloc="pic",
        codemodel="small",
        jit=True,
    )


@functools.cache
def _made_for() -> tuple[str, str, int]:
    """Processor, its features and LLVM's level: this one's, or what numba's settings say."""
    settings, features = numba.config, numba.config.CPU_FEATURES
    own = llvm.get_host_cpu_features().flatten() if features is None else features
    level = min(int(settings.OPT), numba_private.LEVEL)
    return settings.CPU_NAME or llvm.get_host_cpu_name(), own, level


_kept_loaded: list["Loaded"] = []  # functions of machine code may be held by anybody


class Loaded:
    """Machine code in memory, as long as the process lives."""

    def __init__(self, code: bytes) -> None:
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        _kept_loaded.append(self)

    def address(self, name: str) -> int:
        """Where a function begins."""
        found: int = self._engine.get_function_address(name)
        return found

    def function(self, name: str, given: Iterable[Any]) -> Callable[..., int]:
        """A function by name, callable from Python without the interpreter's lock."""
        return ctypes.CFUNCTYPE(ctypes.c_int64, *given)(self.address(name))


def loaded(origin: str, make: Callable[[], ir.Module], lanes: bool = True) -> Loaded:
    """Machine code of a module that is made where it is not yet kept under its `origin`.

    lanes: its numbers are vectors as they are; else loops work on several numbers at a time.
    """
    path = _path(origin)
    code = _kept(path)
    if code is None:
        with alone(f"compile {path}", wait=True):  # who waits finds it
            code = _kept(path)
            if code is None:
                with numba_private.no_collection():
                    code = _compiled(make(), lanes)
                _keep(path, code)
    return Loaded(code)


def _keep(path: Path, code: bytes) -> None:
    """Write it for the next time; where that cannot be, say so and go on."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, hashlib.sha256(code).digest() + code)
    except (OSError, BadInput) as error:
        warn_not_kept(error)


def is_kept(origin: str) -> bool:
    """Whether there is such code on disk."""
    return _path(origin).exists()


def kept(origin: str) -> bytes | None:
    """Such code from the disk, None where it is missing or damaged."""
    return _kept(_path(origin))


def _path(origin: str) -> Path:
    python = sys.implementation.cache_tag, sys.abiflags, object.__basicsize__
    made_by = _made_for(), llvm.llvm_version_info, llvmlite.__version__, python
    digest = hashlib.sha256(f"{origin} {made_by}".encode()).hexdigest()
    return cache_folder() / f"lanes_{digest[:16]}.o"


def _kept(path: Path) -> bytes | None:
    """What a file holds, None where it is missing or damaged."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    return data[32:] if hashlib.sha256(data[32:]).digest() == data[:32] else None


def _compiled(module: ir.Module, lanes: bool = True) -> bytes:
    target = _target()
    for each in module.functions:
        if lanes and not each.is_declaration:
            each.attributes._known = frozenset({*each.attributes._known, *_WIDE})
            for attribute in _WIDE:
                each.attributes.add(attribute)
    parsed = llvm.parse_assembly(str(module))
    tuning = llvm.create_pipeline_tuning_options(_made_for()[2])
    tuning.loop_vectorization, tuning.slp_vectorization = not lanes, False
    builder = llvm.create_pass_builder(target, tuning)
    builder.getModulePassManager().run(parsed, builder)
    return target.emit_object(parsed)
