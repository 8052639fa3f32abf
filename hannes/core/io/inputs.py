"""Which files a command reads: noted where they are opened, so that no output takes their place."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_NOTED: ContextVar[set[Path] | None] = ContextVar("_NOTED", default=None)


def note(path: str | Path) -> None:
    """Say that a file or folder is read; nothing where nobody listens."""
    found = _NOTED.get()
    if found is not None and "\0" not in str(path):
        found.add(Path(os.path.realpath(path)))


@contextmanager
def noted() -> Iterator[set[Path]]:
    """Yield a set that holds the real path of all that is read within; those around get it too."""
    outer, found = _NOTED.get(), set[Path]()
    token = _NOTED.set(found)
    try:
        yield found
    finally:
        _NOTED.reset(token)
        if outer is not None:
            outer |= found


@contextmanager
def unnoted() -> Iterator[None]:
    """Note nothing that is read within: a look at what stands where an output will be."""
    token = _NOTED.set(None)
    try:
        yield
    finally:
        _NOTED.reset(token)


def is_file(path: str | Path) -> bool:
    """Whether a regular file lies there; no, too, for a name that no file can have."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False
