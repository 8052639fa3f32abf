"""Loads Python that was consented to: those files and no other, with no folder on `sys.path`.

Modules get a name of their own, under a digest of the files: two folders may each have a `cart.py`,
and kept machine code finds them again wherever they lie. What they import from beside them is
looked for among the files that were consented to; all else is found as usual.
"""

import builtins
import importlib
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.trust.python_source import File, Source, ships

PREFIX = "hannes_own_"  # starts the name of the package that holds a user's files
_SOURCES: dict[str, Source] = {}


def load(source: Source) -> Any:
    """Run what `source` means and return the object; BadInput where that fails.

    Nobody is asked here: see consent.py.
    """
    module = source.module
    if source.folder is not None:
        package = f"{PREFIX}{source.digest[:16]}"
        _SOURCES.setdefault(package, source)
        if _FINDER not in sys.meta_path:
            sys.meta_path.append(_FINDER)
        module = f"{package}.{module}"
    try:
        found = importlib.import_module(module)
    except (Exception, SystemExit) as error:  # the user's module may do anything
        raise BadInput(f"{source.name} does not run: {_words(error)}") from None
    try:
        return getattr(found, source.attribute)
    except AttributeError:
        where = f"{source.origin} has nothing named {source.attribute}"
        raise BadInput(f"{source.name} cannot be loaded: {where}") from None


def own_modules() -> list[ModuleType]:
    """Modules of users' files that this process has loaded."""
    return [
        module
        for name, module in list(sys.modules.items())
        if name.startswith(PREFIX) and getattr(module, "__file__", None)
    ]


def _words(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]


class _Finder(importlib.abc.MetaPathFinder):
    """Finds modules under the names given here, and no other."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package, _, module = fullname.partition(".")
        source = _SOURCES.get(package)
        if source is None:
            return None
        file = source.files.get(module)
        if file is None and module and not _holds(source, module):
            return None
        spec = importlib.machinery.ModuleSpec(
            fullname,
            _Loader(package, source, file),
            origin=str(file.path) if file else None,
            is_package=file is None or file.package,
        )
        spec.has_location = file is not None
        return spec


_FINDER = _Finder()


def _holds(source: Source, module: str) -> bool:
    """Whether files lie below a module that has none of its own."""
    return any(name.startswith(f"{module}.") for name in source.files)


class _Loader(importlib.abc.InspectLoader):
    """Runs the bytes that were consented to, whatever lies there now, and no compiled copy."""

    def __init__(self, package: str, source: Source, file: File | None) -> None:
        self.package, self.source, self.file = package, source, file

    def get_source(self, fullname: str) -> str:
        return self.file.content.decode("utf-8", "replace") if self.file else ""

    def exec_module(self, module: ModuleType) -> None:
        if self.file is None:
            return
        space = vars(module)
        if len(self.source.files) > 1:
            space["__builtins__"] = {**vars(builtins), "__import__": self._import}
        exec(compile(self.file.content, str(self.file.path), "exec", dont_inherit=True), space)

    def _import(
        self,
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> Any:
        """As the statement does, with files beside the importing one under their own names."""
        top = name.partition(".")[0]
        beside = top in self.source.files or _holds(self.source, top)
        if level or not beside or ships(name):
            return builtins.__import__(name, globals, locals, fromlist, level)
        found = builtins.__import__(f"{self.package}.{name}", globals, locals, fromlist, 0)
        return found if fromlist else sys.modules[f"{self.package}.{top}"]


def place(module: ModuleType) -> Path:
    """File of a user's module."""
    return Path(str(module.__file__)).resolve()
