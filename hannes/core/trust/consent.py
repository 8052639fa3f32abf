"""Whether Python that a TOML names may run: asked for, remembered, refused in one line.

Names given on the command line, or by whoever calls the library, have consent. Those in a TOML need
it, and it is remembered as direnv does: under a digest of the TOML's place and content and of every
file of Python that it names or that these import from beside them. Data never gets so far.
"""

import hashlib
import json
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from enum import Enum
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput, NotTrusted, printable
from hannes.core.io.atomic_files import real_path
from hannes.core.io.toml_table import parsed, read_text
from hannes.core.trust.loader import load
from hannes.core.trust.python_source import Source, is_own, located

MOST_FILES = 50  # TOML files to which one leads
SIMULATED = "simulated:"
LEADING = ("base", "hand", "experiment", "mapping")  # keys whose values may be such files


class Consent(Enum):
    """How much is taken for consent to Python that a TOML names."""

    NEVER = "never"  # a mere look
    REMEMBERED = "remembered"  # by `hannes trust`
    ASK = "ask"  # that, or a yes at the terminal
    GIVEN = "given"  # --trust, trust=True


_CURRENT: ContextVar[Consent] = ContextVar("_CURRENT", default=Consent.REMEMBERED)
_GRANTED: set[str] = set()  # digests of what runs in this process already, or may


@contextmanager
def consenting(trust: bool | Consent) -> Iterator[None]:
    """Within, `trust` holds: True for any Python that a TOML names; False changes nothing."""
    given = trust if isinstance(trust, Consent) else Consent.GIVEN if trust else _CURRENT.get()
    token = _CURRENT.set(given)
    try:
        yield
    finally:
        _CURRENT.reset(token)


def own_object(name: str, folder: Path, toml: str | Path | None = None) -> Any:
    """Return the object that `name` means to a file in `folder`, which may run Python.

    `toml` is the file that names it, None where the user or a program does. Raises BadInput where
    nobody consented, or where it does not run.
    """
    source = located(name, folder)
    if toml is not None and source.digest not in _GRANTED:
        _require(Path(toml), source)
    grant((source.digest,))
    return load(source)


def granted() -> tuple[str, ...]:
    """Digests of what may run in this process: to be granted in its workers too."""
    return tuple(sorted(_GRANTED))


def grant(digests: Iterable[str]) -> None:
    """Let Python of these digests run in this process."""
    _GRANTED.update(digests)


def remember(toml: Path) -> dict[Path, list[Source]]:
    """Remember consent to all Python that a TOML and those it leads to name; returns that.

    Raises BadInput where nothing can be read or kept.
    """
    found, first = {}, str(real_path(toml))
    for path in reached(toml):
        if sources := named(path):
            kept = _kept(digest(path, sources))
            python = [each.origin for each in sources]
            content = {"file": str(path.resolve()), "for": first, "python": python}
            try:
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
            except OSError as error:
                why = error.strerror or error
                raise BadInput(
                    f"cannot remember this in {kept.parent}: {why}; set XDG_CONFIG_HOME to a "
                    "folder that can be written, or add --trust to the command"
                ) from None
            found[path] = sources
    return found


def forget(toml: Path) -> int:
    """Forget what was remembered of a TOML at this place, or for its sake; how many there were.

    Whatever its content: what it leads to is what it led to when consent was given.
    """
    place, gone = str(real_path(toml)), 0
    for kept in _kept("x").parent.glob("*"):
        with suppress(OSError, ValueError, AttributeError):
            known = json.loads(kept.read_text(encoding="utf-8"))
            if place in (known.get("file"), known.get("for")):
                kept.unlink()
                gone += 1
    return gone


def named(toml: Path) -> list[Source]:
    """Python that a TOML itself names, none of it run."""
    content = _content(toml)
    effects = content.get("effects", [])
    texts = [content.get("plant"), content.get("base"), *(effects if _is_list(effects) else [])]
    own = [each for each in texts if isinstance(each, str) and is_own(each)]
    return [located(name, toml.parent) for name in dict.fromkeys(own)]


def reached(toml: Path) -> list[Path]:
    """A TOML and those it leads to, itself first."""
    found, waiting = dict[Path, None](), [toml]
    while waiting and len(found) < MOST_FILES:
        path = waiting.pop(0)
        content = _content(path)
        if path.resolve() in {each.resolve() for each in found}:
            continue
        found[path] = None
        rows = content.get("recording", [])
        tables = [content, *(row for row in (rows if _is_list(rows) else []) if _is_dict(row))]
        texts = [table.get(key) for table in tables for key in LEADING]
        texts += [str(table.get("file")).removeprefix(SIMULATED) for table in tables]
        names = [each for each in texts if isinstance(each, str) and each.endswith(".toml")]
        waiting += [path.parent / name for name in names if _is_file(path.parent / name)]
    return list(found)


def digest(toml: Path, sources: Iterable[Source]) -> str:
    """Of a TOML's place and content, and of all the Python that it names."""
    found = hashlib.sha256(f"{toml.resolve()}\n".encode() + read_text(toml).encode())
    for each in sources:
        found.update(f"\n{each.name} {each.folder} {each.digest}".encode())
    return found.hexdigest()


def _is_file(path: Path) -> bool:
    """Whether there is a file; none has a name that the system does not take."""
    try:
        return path.is_file()
    except OSError:
        return False


def _is_list(value: object) -> bool:
    return isinstance(value, list)


def _is_dict(value: object) -> bool:
    return isinstance(value, dict)


def _content(toml: Path) -> dict[str, Any]:
    try:
        return parsed(read_text(toml))
    except (ValueError, RecursionError):
        return {}  # reported by its own reader


def _kept(name: str) -> Path:
    return config_home() / "trusted" / name


def config_home() -> Path:
    """Folder of hannes among the user's settings (XDG_CONFIG_HOME overrides its parent)."""
    home = os.environ.get("XDG_CONFIG_HOME")
    try:
        return (Path(home) if home else Path.home() / ".config") / "hannes"
    except RuntimeError:
        raise BadInput(
            "there is no home folder to remember anything in: set XDG_CONFIG_HOME"
        ) from None


def _require(toml: Path, source: Source) -> None:
    """Raise BadInput unless somebody consented to what `toml` names."""
    how = _CURRENT.get()
    if how is Consent.GIVEN:
        return
    if how is not Consent.NEVER and toml.is_file():
        sources = named(toml)
        if source.digest in {each.digest for each in sources}:
            if _remembered(digest(toml, sources)) or (how is Consent.ASK and _yes(toml, sources)):
                grant(each.digest for each in sources)
                return
    raise NotTrusted(
        f"{toml} names Python of its own, which would run with your rights ({source.origin}): look "
        f"at it, then add --trust (in Python trust=True) or run `hannes trust {toml}` once"
    )


def _remembered(name: str) -> bool:
    with suppress(OSError, BadInput):
        return _kept(name).is_file()
    return False


def _yes(toml: Path, sources: Iterable[Source]) -> bool:
    """Ask at the terminal, where there is one."""
    if not (sys.stdin and sys.stdin.isatty() and sys.stderr and sys.stderr.isatty()):
        return False
    lines = [f"{toml} names Python of its own, which would run with your rights:"]
    lines += [f"  {each.name}, from {each.origin}" for each in sources]
    print("\n".join(map(printable, lines)), file=sys.stderr)
    print(
        "Run it now? (`hannes trust` remembers a yes) [y/N] ", end="", file=sys.stderr, flush=True
    )
    return sys.stdin.readline().strip().lower() in ("y", "yes")
