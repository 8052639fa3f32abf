"""Files that are whole or absent: written under a temporary name, flushed, then renamed.

A folder of results is swapped in by one exchange of names where the system has that call (Linux
`renameat2`). Elsewhere the old folder is renamed first. If the command is killed in between, the
next write or call of `settled(path)` restores it.
"""

import ctypes
import errno
import os
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hannes.core.errors import BadInput
from hannes.core.io.result_marks import changed, folder_mark, foreign, mark_folder

_STALE = 7 * 86400  # s, age at which the leftover of a killed command is removed

_REASONS = {
    errno.EACCES: "permission denied; choose a place you may write to",
    errno.EPERM: "permission denied; choose a place you may write to",
    errno.EROFS: "the file system is read-only; choose another place",
    errno.ENOSPC: "no space left on the disk; free some and try again",
    errno.EDQUOT: "the disk quota is used up; free some space and try again",
    errno.EFBIG: "the file grew larger than the system allows",
    errno.ENOTDIR: "a part of its path is a file, not a folder",
    errno.EEXIST: "a part of its path is a file, not a folder",
    errno.EISDIR: "it is a folder; give the name of a file",
    errno.ENAMETOOLONG: "the name is too long",
}
BODY_FAULTS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def write_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8, line ends as they are; BadInput if `path` cannot be written."""
    write_bytes(path, text.encode())


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write `data`; BadInput if `path` cannot be written."""
    with atomic_file(path) as temporary:
        temporary.write_bytes(data)


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path (same folder, same suffix) that replaces `path` on success.

    On any exception the temporary file is removed and `path` keeps what it had.
    """
    target = real_path(path)
    with _explained(target):
        _require_regular(target)
        temporary = _temporary(target)
    try:
        with _explained(target, BODY_FAULTS):
            yield temporary
        with _explained(target):
            _flush(temporary)
            os.replace(temporary, target)
            _flush(target.parent)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: str | Path, verb: str = "", force: bool = False) -> Iterator[Path]:
    """Yield an empty temporary folder that takes the place of `path` on success.

    Earlier results of the same verb are replaced as a whole, with `force` those of any; other files
    that lie among them are kept. A folder that hannes did not write is refused with BadInput unless
    it is empty, and so is one in which results were changed since.
    """
    with _explained(Path(path)):
        target = settled(path)
        require_replaceable(target, verb, force)
        temporary = _temporary(target)
        temporary.mkdir()
    try:
        with _explained(target, BODY_FAULTS):
            yield temporary
        with _explained(target):
            _finish(temporary, target, verb)
            _swap(temporary, target)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def require_replaceable(target: Path, verb: str, force: bool) -> None:
    """Raise BadInput unless results of `verb` may take the place of what stands at `target`."""
    if not os.path.lexists(target):
        return
    if not target.is_dir():
        raise BadInput(f"cannot write {target}: it is a file; give the name of a folder")
    if not any(target.iterdir()):
        return
    mark = folder_mark(target)
    if mark is None:
        raise BadInput(
            f"cannot write {target}: the folder holds files that are not earlier results; "
            "choose a new or an empty folder"
        )
    if mark.verb not in (None, verb) and not force:
        raise BadInput(
            f"cannot write {target}: it holds results of {_named(mark.verb)}; choose another "
            "folder, or replace them with --force"
        )
    if edited := changed(target, mark):
        raise BadInput(
            f"cannot write {target}: {edited[0]} in it was changed since it was written; "
            "move it away, or choose another folder"
        )


def _named(verb: str | None) -> str:
    return f"`hannes {verb}`" if verb else "another program"


def settled(path: str | Path) -> Path:
    """Return the real path of a results folder, restored first if a swap was interrupted."""
    target = real_path(path)
    aside = _aside(target)
    if aside.is_dir() and not target.exists():
        os.rename(aside, target)
    return target


@contextmanager
def _explained(target: Path, only: tuple[int, ...] = ()) -> Iterator[None]:
    """Turn an OSError about `target` into one line of BadInput; `only` narrows the kinds."""
    try:
        yield
    except OSError as error:
        if only and error.errno not in only:
            raise
        reason = _REASONS.get(error.errno or 0, error.strerror or str(error))
        raise BadInput(f"cannot write {target}: {reason}") from error


def real_path(path: str | Path) -> Path:
    """Return the path without links; BadInput for a name that no file can have."""
    if "\0" in str(path):
        raise BadInput(f"cannot write {str(path)!r}: the name holds a NUL character")
    return Path(os.path.realpath(path))


def _require_regular(target: Path) -> None:
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder")
    if target.exists() and not target.is_file():
        raise BadInput(f"cannot write {target}: it is a device or pipe; give the name of a file")


def _temporary(target: Path) -> Path:
    """Return an unused name beside `target`, after removing leftovers a week old."""
    target.parent.mkdir(parents=True, exist_ok=True)
    for leftover in target.parent.glob(".tmp-*.*"):
        if leftover.name.split(".", 2)[2:] == [target.name] and _age(leftover) > _STALE:
            _remove(leftover)
    return target.parent / f".tmp-{os.urandom(6).hex()}.{target.name}"


def _age(path: Path) -> float:
    with suppress(OSError):
        return time.time() - path.stat().st_mtime
    return 0.0


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _finish(temporary: Path, target: Path, verb: str) -> None:
    """Mark the new results, copy over what is kept, flush all to the disk."""
    mark_folder(temporary, verb)
    mark = folder_mark(target)
    for name in foreign(target, mark) if mark else []:
        _keep(target, temporary, name)
    for each in temporary.rglob("*"):
        if each.is_file() and not each.is_symlink():
            _flush(each)
    _flush(temporary)


def _keep(target: Path, temporary: Path, name: str) -> None:
    """Copy what lies among old results to the new ones; BadInput where one has that name."""
    old, new = target / name, temporary / name
    if os.path.lexists(new) and not (old.is_dir() and new.is_dir()):
        raise BadInput(
            f"cannot write {target}: {name} in it was not written by hannes and has the name of a "
            "result; move it away, or choose another folder"
        )
    try:
        new.parent.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise BadInput(f"cannot write {target}: {name} in it lies where a result goes") from None
    if old.is_dir() and not old.is_symlink():
        new.mkdir(exist_ok=True)
    else:
        shutil.copy2(old, new, follow_symlinks=False)


def _swap(temporary: Path, target: Path) -> None:
    """Give `temporary` the name `target`; the former content is removed."""
    aside = _aside(target)
    shutil.rmtree(aside, ignore_errors=True)
    if not target.exists():
        os.rename(temporary, target)
    elif not _exchange(temporary, target):
        os.rename(target, aside)
        try:
            os.rename(temporary, target)
        finally:
            settled(target)
        shutil.rmtree(aside, ignore_errors=True)
    _flush(target.parent)


def _aside(target: Path) -> Path:
    return target.parent / f".old.{target.name}"


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two names in one step; False where the system or file system cannot."""
    if sys.platform != "linux":
        return False
    try:
        call = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):  # a C library without the call
        return False
    at_cwd, exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE of linux/fs.h
    return call(at_cwd, os.fsencode(one), at_cwd, os.fsencode(other), exchange) == 0


def _flush(path: Path) -> None:
    """Force a file or folder to the disk, where the system can."""
    if path.is_dir() and os.name == "nt":
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF):
            raise
    finally:
        os.close(handle)
