"""The catalogue of effects: every module under dynamics, contact and control with an EFFECT."""

import functools
import hashlib
import importlib
import importlib.util
import pkgutil
from pathlib import Path

from hannes import contact, control, dynamics
from hannes.effect import Effect
from hannes.errors import BadInput, nearest


@functools.cache
def effects() -> dict[str, Effect]:
    """All effects that ship with hannes, by name, in alphabetical order."""
    found = {}
    for package in (dynamics, contact, control):
        for module in pkgutil.iter_modules(package.__path__):
            loaded = importlib.import_module(f"{package.__name__}.{module.name}")
            if (effect := getattr(loaded, "EFFECT", None)) is not None:
                found[effect.name] = effect
    return dict(sorted(found.items()))


def effect(name: str, folder: Path | None = None) -> Effect:
    """Return a catalogue effect, or the user's own from `path/to/file.py:EFFECT`.

    Relative paths start at `folder` (the file that names the effect). Raises BadInput when the
    name is unknown or the file does not hold an Effect.
    """
    if ".py:" in name:
        path, _, attribute = name.rpartition(":")
        return _own_effect((folder or Path.cwd()) / path, attribute)
    if name not in effects():
        raise BadInput(f'unknown effect "{name}"{nearest(name, effects())}')
    return effects()[name]


def _own_effect(path: Path, attribute: str) -> Effect:
    try:
        source = path.read_bytes()
    except OSError as error:
        raise BadInput(f"cannot read effect file {path}: {error.strerror}") from None
    digest = hashlib.sha256(source).hexdigest()[:16]
    spec = importlib.util.spec_from_file_location(f"hannes_own_{path.stem}_{digest}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise BadInput(f"effect file {path} does not run: {error}") from None
    found = getattr(module, attribute, None)
    if not isinstance(found, Effect):
        raise BadInput(f"{path} has no Effect named {attribute}")
    return found
