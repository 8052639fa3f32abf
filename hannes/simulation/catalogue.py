"""The catalogue of effects: every module under dynamics, contact and control with an EFFECT."""

import functools
import importlib
import pkgutil
from pathlib import Path
from typing import Any

from hannes import contact, control, dynamics
from hannes.core.description import Description
from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest
from hannes.core.trust.consent import own_object
from hannes.core.trust.loader import own_modules, place
from hannes.core.trust.python_source import is_own


@functools.cache
def effects() -> dict[str, Effect]:
    """All effects that ship with hannes, by name, in alphabetical order."""
    return _found("EFFECT")


@functools.cache
def laws() -> dict[str, Effect]:
    """Laws that take the place of one of the base model: used by name, never a diagnosis' guess."""
    return _found("LAW")


@functools.cache
def descriptions() -> dict[str, Description]:
    """Generic disturbances that ship: used by name, in the place of what no law is known for."""
    return _found("GENERIC")


def laws_of_objects() -> dict[str, Effect]:
    """Laws by which an object moves: what an experiment handles, not the hand."""
    return {
        name: law
        for name, law in laws().items()
        if any(channel.startswith("object_") for term in law.terms for channel in term.writes)
    }


def named() -> dict[str, Effect]:
    """All that a file may name without a path: effects, laws and generic disturbances."""
    generic = {name: each.effect for name, each in descriptions().items()}
    return effects() | laws() | generic


def _found(attribute: str) -> dict[str, Any]:
    """By name, of every module that has one; a description goes by its effect's name."""
    found = {}
    for package in (dynamics, contact, control):
        for module in pkgutil.iter_modules(package.__path__):
            loaded = importlib.import_module(f"{package.__name__}.{module.name}")
            if (each := getattr(loaded, attribute, None)) is not None:
                found[getattr(each, "effect", each).name] = each
    return dict(sorted(found.items()))


def effect(name: str, folder: Path | None = None, toml: str | Path | None = None) -> Effect:
    """Return a catalogue effect or law, or the user's own by `file.py:NAME` or `module:NAME`.

    Relative paths start at `folder`; `toml` is the file that names it, which needs consent
    (docs/explanation/trust.md). Raises BadInput when the name is unknown or no Effect is there.
    """
    if is_own(name):
        found = own_object(name, folder or Path.cwd(), toml)
        if not isinstance(found, Effect):
            place, _, attribute = name.rpartition(":")
            raise BadInput(f"{place} has no Effect named {attribute}")
        return found
    if name not in named():
        raise BadInput(f'unknown effect "{name}"{nearest(name, named())}')
    return named()[name]


def own_effects() -> dict[str, Effect]:
    """The user's own effects that this process has loaded, by `path/to/file.py:EFFECT`."""
    return {
        f"{place(module)}:{name}": value
        for module in own_modules()
        for name, value in vars(module).items()
        if isinstance(value, Effect)
    }
