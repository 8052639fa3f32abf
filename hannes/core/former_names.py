"""Former names of modules, channels and attributes that users' files have, for one release.

`from hannes.effect import Effect` still works: it loads the module of today, and warns.
"""

import importlib
import re
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any, TypeVar, cast

from hannes.core.former_modules import MOVED

AnyClass = TypeVar("AnyClass", bound=type)

_COMMENT = re.compile(r"(?m)^( *)# effects: (\w+(?:, \w+)*)$")
CHANNELS = {"told_force": "logged_force", "told_sensor": "logged_sensor"}


class MovedWarning(DeprecationWarning):
    """A file imports hannes by a name that the next release will not know."""


class Finder:
    """Finds a module by its former name."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Return how to load a module that has a former name, None for all others."""
        package, _, module = name.partition(".")
        found = package == "hannes" and module in MOVED
        return ModuleSpec(name, cast(Any, _Loader)) if found else None


class _Loader:
    """Puts the module of today in the place of the one asked for."""

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """As importlib does it."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        """Warn, and let the module of today stand under the former name."""
        name = module.__name__
        today = MOVED[name.partition(".")[2]]
        warnings.warn(f"{name} goes with the next release: {_advice(today)}", MovedWarning, 2)
        sys.modules["hannes"].__class__ = _Package
        sys.modules[name] = importlib.import_module(f"hannes.{today}")


class _Package(ModuleType):
    """Keeps `hannes.simulate` the function: loading a module of that name would hide it."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in self.__all__ or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


def _advice(today: str) -> str:
    homes: dict[str, str] = sys.modules["hannes"]._HOMES
    public = sorted(name for name, home in homes.items() if home == today)
    also = f"from hannes import {', '.join(public)}, or " if public else ""
    return f"write {also}hannes.{today}"


def channel(name: str) -> str:
    """Return the present name of a channel of effects; warn on a former one."""
    if name in CHANNELS:
        advice = f"the channel {name} goes with the next release: write {CHANNELS[name]}"
        warnings.warn(advice, MovedWarning, 2)
    return CHANNELS.get(name, name)


def opened(text: str) -> str:
    """Text of equations with each former comment `# effects: a, b` as a statement; warn on one."""
    found, count = _COMMENT.subn(r"\1\2 = effects(\2)", text)
    if count:
        advice = "comments `# effects: a, b` go with the next release: write `a, b = effects(a, b)`"
        warnings.warn(f"{advice}, with effects from hannes.core.kernels.insertion", MovedWarning, 2)
    return found


def attributes(names: Mapping[str, str]) -> Callable[[AnyClass], AnyClass]:
    """Decorate a class so that former names of its attributes can be read, with a warning.

    names: former name -> that of today
    """

    def with_former(owner: AnyClass) -> AnyClass:
        for former, today in names.items():
            setattr(owner, former, _former(owner.__name__, former, today))
        return owner

    return with_former


def _former(owner: str, former: str, today: str) -> property:
    def read(instance: Any) -> Any:
        advice = f"{owner}.{former} goes with the next release: write {today}"
        warnings.warn(advice, MovedWarning, 2)
        return getattr(instance, today)

    return property(read, doc=f"Former name of `{today}`.")


def install() -> None:
    """Look up former names first; warn on them where nothing else is asked for.

    First, for `hannes.diagnosis.search` would else be found beside what stands there today, and be
    loaded a second time.
    """
    sys.meta_path.insert(0, Finder)
    if not sys.warnoptions:  # else users would not see what is not of their own __main__
        warnings.filterwarnings("default", category=MovedWarning)
