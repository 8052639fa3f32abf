"""Machine code on disk: whole or made anew, and made by one process where several want it.

numba keeps it without a check of its own: a file cut short ends in a traceback, a flipped bit in
code that is run. Here each file begins with the SHA-256 of the rest, and code comes with the key
under which it was kept.
"""

import functools
import hashlib
import pickle
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hannes.core.io.locks import alone

_HEAD = hashlib.sha256().digest_size
_compiling: list[str] = []  # what this process holds the lock of, at most one


def checked(dispatcher: Any) -> None:
    """Let a function compiled with `cache=True` keep its code so."""
    kept = getattr(dispatcher._cache, "_cache_file", None)
    if kept is not None:
        kept.__class__ = _class()


@contextmanager
def one_process(dispatcher: Any) -> Iterator[None]:
    """Within, no other process compiles the functions of the same module: they wait, then load."""
    if _compiling:  # one lock at most is held, so that no two wait for each other
        yield
        return
    name = f"compile {dispatcher.py_func.__code__.co_filename}"
    with alone(name, wait=True):
        _compiling.append(name)
        try:
            yield
        finally:
            _compiling.pop()


def _sealed(content: Any, dump: Any) -> bytes:
    data = dump(content)
    return hashlib.sha256(data).digest() + data


def _unsealed(path: str) -> Any:
    """Content of a file, a tuple; None where it is missing, damaged or of another kind."""
    try:
        data = Path(path).read_bytes()
        if hashlib.sha256(data[_HEAD:]).digest() == data[:_HEAD]:
            return pickle.loads(data[_HEAD:])
    except Exception:  # unpickling raises nearly anything
        pass
    return None


@functools.cache
def _class() -> type[Any]:
    from numba.core.caching import IndexDataCacheFile

    class Kept(IndexDataCacheFile):
        """An index file, and a file of code for each key of it; code is written first."""

        def save(self, key: Any, data: Any) -> None:
            try:
                index = self._load_index()
                taken = set(index.values())
                free = (self._data_name(k) for k in range(1, len(taken) + 2))
                name = index.get(key) or next(each for each in free if each not in taken)
                self._write(self._data_path(name), (key, data))
                self._save_index({**index, key: name})
            except OSError as error:  # a full disk: it is compiled anew next time
                warn_not_kept(error)

        def load(self, key: Any) -> Any:
            name = self._load_index().get(key)
            found = _unsealed(self._data_path(name)) if name is not None else None
            return found[1] if found is not None and found[0] == key else None

        def _load_index(self) -> dict[Any, str]:
            found = _unsealed(self._index_path)
            if found is None or found[:2] != (self._version, self._source_stamp):
                return {}
            return found[2]

        def _save_index(self, overloads: dict[Any, str]) -> None:
            self._write(self._index_path, (self._version, self._source_stamp, overloads))

        def _write(self, path: str, content: Any) -> None:
            with self._open_for_write(path) as file:
                file.write(_sealed(content, self._dump))

    return Kept


@functools.cache
def warn_not_kept(error: Exception) -> None:
    """Say that code is compiled anew next time, and why."""
    why = getattr(error, "strerror", None) or error
    print(
        f"hannes: compiled code cannot be kept ({why}): it is compiled anew "
        "next time; free some space or set HANNES_CACHE",
        file=sys.stderr,
    )
