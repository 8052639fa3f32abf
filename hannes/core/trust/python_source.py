"""Python that a name such as `cart.py:Cart` or `cart:Cart` would run: found, none of it run.

A name is a file and what to take from it, or a module and that. A module that lies as a file in the
folder of whoever names it is that file; others are installed modules. Of a file, the files beside
it that it imports belong to it, as far as they can be read off its text.
"""

import ast
import hashlib
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hannes.core.errors import BadInput
from hannes.core.io.bounded import read_bytes

MOST_FILES = 200
LARGEST = 2_000_000  # bytes of one file
_MODULE = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*")


@dataclass(frozen=True)
class File:
    """One file of Python as it was read: what runs are these bytes, whatever lies there later."""

    path: Path
    content: bytes

    @property
    def package(self) -> bool:
        """Whether it is the `__init__.py` of a package."""
        return self.path.name == "__init__.py"


@dataclass(frozen=True)
class Source:
    """What a name means: `attribute` of `module`, its `files` by module name (none: installed)."""

    name: str
    module: str
    attribute: str
    folder: Path | None
    files: Mapping[str, File]

    @cached_property
    def digest(self) -> str:
        """Of all that would run, and of the folder where a file asks for its own place."""
        if self.folder is None:
            return f"installed {self.module}"
        found = hashlib.sha256()
        for module, file in sorted(self.files.items()):
            found.update(f"{module} {len(file.content)} ".encode() + file.content)
        if any(b"__file__" in file.content for file in self.files.values()):
            found.update(str(self.folder).encode())
        return found.hexdigest()

    @property
    def origin(self) -> str:
        """Where it comes from, for a person."""
        if self.folder is None:
            return f"the installed module {self.module}"
        first, *others = (str(file.path) for file in self.files.values())
        return f"{first} and what it imports ({', '.join(others)})" if others else first


def is_own(name: str) -> bool:
    """Whether a name means Python that does not ship with hannes."""
    return ":" in name


def located(name: str, folder: Path) -> Source:
    """Return what `name` means to a file in `folder`; BadInput where it cannot be read."""
    place, _, attribute = name.rpartition(":")
    if not attribute.isidentifier() or not place.isprintable():
        raise BadInput(f"{name!r:.200} names no Python: expected file.py:NAME or module:NAME")
    if place.endswith(".py"):
        path = (folder / place).resolve()
        module = re.sub(r"\W", "_", path.stem)
        return Source(name, module, attribute, path.parent, _closure(path.parent, module, path))
    if not _MODULE.fullmatch(place):
        raise BadInput(f"{name!r:.200} names no Python: expected file.py:NAME or module:NAME")
    beside = _beside(folder.resolve(), place)
    if beside is None:
        return Source(name, place, attribute, None, {})
    return Source(name, place, attribute, folder.resolve(), _closure(folder.resolve(), place))


def _beside(folder: Path, module: str) -> Path | None:
    """File of a module that lies in a folder."""
    place = folder.joinpath(*module.split("."))
    for path in (place / "__init__.py", place.with_name(f"{place.name}.py")):
        if path.is_file():
            return path
    return None


def _closure(folder: Path, module: str, first: Path | None = None) -> dict[str, File]:
    """A module's file, and those of its folder that it imports, the one asked for first."""
    files: dict[str, File] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop(0)
        path = first if name == module and first else _beside(folder, name)
        if name in files or path is None:
            continue
        if len(files) == MOST_FILES:
            raise BadInput(f"{folder}: {module} imports more than {MOST_FILES} files beside it")
        files[name] = File(path, _read(path))
        waiting += [*_imported(files[name], name), *_parents(name)]
    return files


def _read(path: Path) -> bytes:
    try:
        return read_bytes(path, "a file of Python", LARGEST)
    except BadInput as error:
        raise BadInput(f"cannot read {error}") from None


def _parents(module: str) -> list[str]:
    parts = module.split(".")
    return [".".join(parts[:k]) for k in range(1, len(parts))]


def _imported(file: File, module: str) -> Iterator[str]:
    """Modules that a file may import: those that ship with Python never come from beside it."""
    try:
        tree = ast.parse(file.content)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return  # reported when it is loaded
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _base(node, module, file.package)
            found = [base, *(f"{base}.{alias.name}".strip(".") for alias in node.names)]
        else:
            continue
        yield from (name for name in found if name and not ships(name))


def _base(node: ast.ImportFrom, module: str, package: bool) -> str:
    """Module from which names are taken, relative ones resolved."""
    if not node.level:
        return node.module or ""
    parts = module.split(".") if package else module.split(".")[:-1]
    above = parts[: len(parts) - node.level + 1]
    return ".".join([*above, *([node.module] if node.module else [])])


def ships(module: str) -> bool:
    """Whether a module is of Python itself or of hannes: none beside a file takes its place."""
    top = module.partition(".")[0]
    return top == "hannes" or top in sys.stdlib_module_names
