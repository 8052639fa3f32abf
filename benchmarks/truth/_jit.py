"""Compiled functions whose disk cache can never be stale.

numba's cache watches only the outer function's file, so the folder is named by a digest of every
source file here and of the versions involved.
"""

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np


def _cache_folder() -> str:
    here = Path(__file__).parent
    digest = hashlib.sha256(f"{sys.version} {numba.__version__} {np.__version__}".encode())
    for source in sorted(here.rglob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return str(here / "__pycache__" / f"numba-{digest.hexdigest()[:16]}")


_FOLDER = _cache_folder()


def inlined(function: Callable) -> Callable:
    """`function` as machine code within that of its callers, which keep it."""
    return numba.njit(error_model="numpy")(function)


def compiled(function: Callable) -> Callable:
    """`function` as machine code (plain Python under NUMBA_DISABLE_JIT=1)."""
    usual = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = _FOLDER
    try:
        return numba.njit(cache=True, error_model="numpy")(function)
    finally:
        numba.config.CACHE_DIR = usual
