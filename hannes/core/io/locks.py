"""One process at a time: locks that the system lets go when their holder dies, however it does."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from hannes.core.io.cache import cache_home

fcntl: Any
try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


@contextmanager
def alone(name: str, wait: bool) -> Iterator[bool]:
    """Hold the lock of a name; yields whether it was free, without `wait` for it to be.

    Where nothing can be locked (no such call, a disk that is full) the name counts as free.
    """
    handle = _opened(name)
    try:
        yield handle is None or _held(handle, wait)
    finally:
        if handle is not None:
            os.close(handle)  # lets go of the lock


def _opened(name: str) -> int | None:
    if fcntl is None:
        return None
    folder = cache_home() / "locks"
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        place = folder / f"{hashlib.sha256(name.encode('utf-8', 'replace')).hexdigest()[:24]}.lock"
        return os.open(Path(place), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    return None


def _held(handle: int, wait: bool) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True
