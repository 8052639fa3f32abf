"""What a command may write, decided before any work: no input, nothing that hannes did not write.

One function for all verbs. A former result of the same verb gives way, one of another verb where
that is asked for (`--force`); all else that stands at a target is refused in one line and stays.
"""

import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.atomic_files import real_path
from hannes.core.io.locks import alone
from hannes.core.io.result_marks import file_verb

LONGEST = 220  # bytes of a name: names of temporary files and of marks are longer


@contextmanager
def reserved(
    verb: str,
    targets: Iterable[str | Path],
    reads: Iterable[str | Path] = (),
    *,
    folder: bool = False,
    force: bool = False,
) -> Iterator[None]:
    """Check what `verb` is about to write, and keep it from other commands within.

    `targets`: files, or folders of results; `reads`: files and folders that are read. Raises
    BadInput, naming the target, for one that must not be written.
    """
    with ExitStack() as held:
        taken: set[Path] = set()
        for target in targets:
            if real_path(target) in taken:
                raise BadInput(f"two results would be written to {target}: give different names")
            taken.add(real_path(target))
            require_free(verb, target, reads, folder=folder, force=force)
            if not held.enter_context(alone(f"write {real_path(target)}", wait=False)):
                raise BadInput(
                    f"another command is writing {target}: wait until it ends, or choose another "
                    "name"
                )
        yield


def require_free(
    verb: str,
    target: str | Path,
    reads: Iterable[str | Path] = (),
    *,
    folder: bool = False,
    force: bool = False,
) -> None:
    """Raise BadInput unless `verb` may write a file, or a `folder` of results, at `target`."""
    real = real_path(target)
    _require_place(target, real)
    for read in reads:
        _require_apart(target, real, real_path(read))
    if folder:
        atomic_files.require_replaceable(real, verb, force)
    elif os.path.lexists(real):
        _require_former(target, real, verb, force)


def _require_place(target: str | Path, real: Path) -> None:
    """Raise BadInput where no file or folder of that name can be made."""
    if Path(target).parts[:1] == ("~",):  # a shell leaves it in --out=~/results
        raise BadInput(f"cannot write {target}: ~ is no folder here; write {Path.home()} for it")
    if any(len(os.fsencode(part)) > LONGEST for part in real.parts):
        raise BadInput(f"cannot write {target!s:.60}...: the name is too long")
    above = next(each for each in real.parents if os.path.lexists(each))
    if not above.is_dir():
        raise BadInput(f"cannot write {target}: a part of its path is a file, not a folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise BadInput(f"cannot write {target}: permission denied in {above}")


def _require_apart(target: str | Path, real: Path, read: Path) -> None:
    if _same(real, read):
        raise BadInput(f"cannot write {target}: it is read here; choose another name")
    if read.is_relative_to(real):
        raise BadInput(f"cannot write {target}: {read} in it is read here; choose another name")


def _same(one: Path, other: Path) -> bool:
    """Whether two paths are one file, by a link to it, too."""
    try:
        return one == other or os.path.samefile(one, other)
    except OSError:
        return False


def _require_former(target: str | Path, real: Path, verb: str, force: bool) -> None:
    """Raise BadInput unless a former result that may be replaced stands at `target`."""
    if real.is_dir():
        raise BadInput(f"cannot write {target}: it is a folder; give the name of a file")
    if not real.is_file():
        raise BadInput(f"cannot write {target}: it is a device or pipe; give the name of a file")
    former = file_verb(real)
    if former is None:
        raise BadInput(
            f"cannot write {target}: it holds something else than a former result, which stays; "
            "choose another name"
        )
    if former != verb and not force:
        raise BadInput(
            f"cannot write {target}: `hannes {former}` wrote what is there; choose another name, "
            "or replace it with --force"
        )
