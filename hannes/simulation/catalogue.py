"""The catalogue of effects: every module under dynamics, contact and control with an EFFECT."""

import functools
import hashlib
import importlib
import importlib.util
import pkgutil
import sys
from pathlib import Path
from types import ModuleType

from hannes import contact, control, dynamics
from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest

_OWN = "hannes_own_"  # starts the module name of a user's file


@functools.cache
def effects() -> dict[str, Effect]:
    """All effects that ship with hannes, by name, in alphabetical order."""
    return _found("EFFECT")


@functools.cache
def laws() -> dict[str, Effect]:
    """Laws that take the place of one of the base model: used by name, never a diagnosis' guess."""
    return _found("LAW")


def laws_of_objects() -> dict[str, Effect]:
    """Laws by which an object moves: what an experiment handles, not the hand."""
    return {
        name: law
        for name, law in laws().items()
        if any(channel.startswith("object_") for term in law.terms for channel in term.writes)
    }


def named() -> dict[str, Effect]:
    """All that a file may name without a path: effects and laws."""
    return effects() | laws()


def _found(attribute: str) -> dict[str, Effect]:
    found = {}
    for package in (dynamics, contact, control):
        for module in pkgutil.iter_modules(package.__path__):
            loaded = importlib.import_module(f"{package.__name__}.{module.name}")
            if (effect := getattr(loaded, attribute, None)) is not None:
                found[effect.name] = effect
    return dict(sorted(found.items()))


def effect(name: str, folder: Path | None = None) -> Effect:
    """Return a catalogue effect or law, or the user's own from `path/to/file.py:EFFECT`.

    Relative paths start at `folder` (the file that names the effect). Raises BadInput when the
    name is unknown or the file does not hold an Effect.
    """
    if ".py:" in name:
        path, _, attribute = name.rpartition(":")
        return _own_effect((folder or Path.cwd()) / path, attribute)
    if name not in named():
        raise BadInput(f'unknown effect "{name}"{nearest(name, named())}')
    return named()[name]


def own_effects() -> dict[str, Effect]:
    """The user's own effects that this process has loaded, by `path/to/file.py:EFFECT`."""
    return {
        f"{Path(str(module.__file__)).resolve()}:{name}": value
        for known, module in list(sys.modules.items())
        if known.startswith(_OWN)
        for name, value in vars(module).items()
        if isinstance(value, Effect)
    }


def _own_effect(path: Path, attribute: str) -> Effect:
    found = getattr(_own_module(path), attribute, None)
    if not isinstance(found, Effect):
        raise BadInput(f"{path} has no Effect named {attribute}")
    return found


def _own_module(path: Path) -> ModuleType:
    """Load a user's file once for each content, under a name that depends on nothing else."""
    try:
        source = path.read_bytes()
    except OSError as error:
        raise BadInput(f"cannot read effect file {path}: {error.strerror}") from None
    name = f"{_OWN}{path.stem}_{hashlib.sha256(source).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where kept machine code looks for the kernels' globals
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise BadInput(f"effect file {path} does not run: {error}") from None
    return module
