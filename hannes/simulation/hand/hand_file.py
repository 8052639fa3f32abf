"""The one home of `hand.toml`: it holds only what differs from the shipped hand, or another plant.

Reading and writing serve any model with named values and effects; `base` names what they change.
"""

import inspect
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from hannes.core.effect import Effect
from hannes.core.errors import BadInput, nearest
from hannes.core.io.toml_table import Table, read_text
from hannes.core.io.units import quantity, text
from hannes.core.kernels.jit import plain
from hannes.core.model import Model, differences
from hannes.core.parameter import Parameter
from hannes.core.ranged import own_ranges, ranged
from hannes.core.trust.consent import consenting
from hannes.simulation import catalogue
from hannes.simulation.hand import finger_tables
from hannes.simulation.hand.hand import Hand

SHIPPED: dict[str, Callable[[], Hand]] = {"hannes": Hand}
KEYS = ("base", "effects", "parameters", finger_tables.KEY)
DEEPEST = 8  # hand files that build on one another


M = TypeVar("M", bound=Model)


def load_hand(name: str | Path, folder: Path | None = None, *, trust: bool = False) -> Hand:
    """Return a shipped hand by name, or the one of a hand.toml (relative to `folder`).

    `trust`: Python that the file names may run. Raises BadInput for an unknown name, a file that is
    not a hand's, Python that nobody consented to.
    """
    if str(name) not in SHIPPED and not str(name).endswith(".toml"):
        raise BadInput(
            f'no hand named "{name}"{nearest(str(name), SHIPPED)} (shipped: {", ".join(SHIPPED)}; '
            "or give the path of a hand.toml)"
        )
    with consenting(trust):
        return load(str(name), folder or Path(), SHIPPED)


def load(name: str, folder: Path, bases: Mapping[str, Callable[[], M]]) -> M:
    """Return the model of a hand.toml, which starts from one of `bases` or from another such file.

    A file without `base` starts from the first. Raises BadInput naming the file and the key.
    """
    if name in bases:
        return bases[name]()
    base, changes = next(iter(bases)), []
    for table in chain(folder / name):
        changes.append(table)
        base = table.text("base", next(iter(bases)))
    if base not in bases:
        changes[-1].refuse("base", f'= "{base}": {_expected(base, bases)}')
    model = bases[base]()
    for table in reversed(changes):
        model = changed(model, table, Path(table.where).parent)
    return model


def chain(path: Path) -> list[Table]:
    """The tables of a hand.toml and of the files on which it builds, itself first."""
    found: list[Table] = []
    base = str(path)
    while base.endswith(".toml"):
        if len(found) == DEEPEST:
            raise BadInput(
                f"{path}: more than {DEEPEST} hand files build on one another, in a circle?"
            )
        found.append(Table.parse(read_text(path), str(path), KEYS))
        base = found[-1].text("base", "")
        path = path.parent / base
    return found


def _expected(base: str, bases: Mapping[str, Any]) -> str:
    return (
        f"expected {' or '.join(bases)}, or the path of a hand.toml{nearest(base, bases)}; values "
        "of another plant serve as base of its campaigns, and `hannes hand` prints them"
    )


def changed(model: M, table: Table, folder: Path | None) -> M:
    """Return `model` with the `effects`, `[parameters]` and `[[finger]]` of a table."""
    present = {each.name: each for each in model.effects}
    for name in table.texts("effects"):
        found = ranged(_effect(name, table, folder, _nameable(model)), own_ranges(model))
        if present.setdefault(found.name, found) != found:
            table.refuse("effects", f'"{name}": another effect has the name "{found.name}"')
        model = model.with_effects(found)
    model = model.with_values(values(table.table("parameters"), model))
    return model.with_values(finger_tables.finger_values(table, model))


def own_catalogue(plant: object) -> Mapping[str, Effect]:
    """Effects that only this plant has; a plant may leave out the attribute `catalogue`."""
    return getattr(plant, "catalogue", {})


def _nameable(model: object) -> Mapping[str, Effect]:
    """What of this plant alone a file may name: its effects and its generic disturbances."""
    generic = {name: each.effect for name, each in getattr(model, "generic", {}).items()}
    return {**own_catalogue(model), **generic}


def _effect(name: str, table: Table, folder: Path | None, known: Mapping[str, Effect]) -> Effect:
    try:
        return known[name] if name in known else catalogue.effect(name, folder, table.where)
    except BadInput as error:
        table.refuse("effects", f"cannot be used: {error}")


def values(table: Table, model: Model) -> dict[str, float]:
    """Return SI values by full name from a table of `"full.name" = "value unit"` lines."""
    return {
        name: checked(given, declared(name, model, table), table)
        for name, given in table.content.items()
    }


def checked(given: object, parameter: Parameter, table: Table) -> float:
    """Return the SI value of a text with its unit for `parameter`; BadInput names the file."""
    number = quantity(given, parameter.unit, f"{table.where}: {parameter.name}")
    try:
        return parameter.check(number)
    except BadInput as error:
        raise BadInput(f"{table.where}: {error}") from None


def declared(name: str, model: Model, table: Table) -> Parameter:
    """Return a parameter's declaration; BadInput separates an absent effect from a misspelling."""
    prefix = name.partition(".")[0]
    if name == "controller.sampled":
        table.refuse(name, 'is not set here: write controller = "sampled" in the experiment')
    if name not in model.parameters.declared and prefix in catalogue.named():
        if prefix not in {each.name for each in model.effects}:
            table.refuse(name, f'belongs to an effect that is not on: add effects = ["{prefix}"]')
    try:
        return model.parameters.require(name)
    except BadInput as error:
        raise BadInput(f"{table.where}: {table.prefix[:-1]}: {error}") from None


def hand_toml(
    model: Model,
    shipped: Model | None = None,
    base: str = "hannes",
    folder: str | Path | None = None,
) -> str:
    """Return the text of the hand.toml that makes `model` from `shipped`, known as `base`.

    Without `shipped` every value that is not the declared one is written. A user's own effects are
    named from `folder`, where the file will lie; without it by their whole path.
    """
    import tomli_w

    numbers = differences(model, shipped)
    fingers = finger_tables.finger_content(model, numbers)
    given = finger_tables.NAMES if fingers else ()
    rest = {name: x for name, x in numbers.items() if name not in given}
    content = {
        "base": base,
        "effects": effect_names(model, folder),
        "parameters": texts(model, rest),
        **({finger_tables.KEY: fingers} if fingers else {}),
    }
    return tomli_w.dumps(content)


def texts(model: Model, numbers: Mapping[str, float]) -> dict[str, str]:
    """Values by full name as texts with their unit."""
    return {name: text(x, model.parameters.require(name).unit) for name, x in numbers.items()}


def effect_names(model: Model, folder: str | Path | None = None) -> list[str]:
    """Names under which a model's effects are found again: catalogue, or `file.py:EFFECT`.

    Files are named from `folder`, without it by their whole path.
    """
    names = [_effect_name(each, model) for each in model.effects]
    return [_seen_from(folder, name) if folder is not None else name for name in names]


def _seen_from(folder: str | Path, name: str) -> str:
    path, _, attribute = name.rpartition(":")
    try:
        near = os.path.relpath(path, os.path.realpath(folder)) if attribute and path else path
    except ValueError:  # on another drive
        near = path
    return f"{Path(near).as_posix()}:{attribute}" if attribute and path else name


def _effect_name(effect: Effect, model: Model) -> str:
    ranges = own_ranges(model)
    known = _nameable(model).get(effect.name) or catalogue.named().get(effect.name)
    if known is not None and ranged(known, ranges) == effect:
        return effect.name
    for place, own in catalogue.own_effects().items():
        if ranged(own, ranges) == effect:
            return place
    function = plain(effect.terms[0].kernel)
    path, found = inspect.getsourcefile(function), function.__globals__
    names = [
        name
        for name, held in found.items()
        if isinstance(held, Effect) and ranged(held, ranges) == effect
    ]
    if not names or not path:
        raise BadInput(f"effect {effect.name} lives in no file, so a hand.toml cannot name it")
    return f"{Path(path).resolve()}:{names[0]}"
