"""Hands by name or from a `hand.toml`, which holds only what differs from the shipped hand."""

import inspect
from collections.abc import Mapping
from pathlib import Path

from hannes import catalogue
from hannes._jit import plain
from hannes.effect import Effect
from hannes.errors import BadInput, nearest
from hannes.hand import Hand
from hannes.parameter import Parameter
from hannes.table import Table, read_text
from hannes.units import quantity, text

SHIPPED = {"hannes": Hand}
KEYS = ("base", "effects", "parameters")
DEEPEST = 8  # hand files that build on one another

_OWN: dict[Effect, str] = {}  # the user's own effects loaded here -> "file.py:EFFECT"


def load_hand(name: str | Path, folder: Path | None = None) -> Hand:
    """Return a shipped hand by name, or the one of a hand.toml (relative to `folder`).

    Raises BadInput for an unknown name or a file that is not a hand.
    """
    return _load(str(name), folder or Path(), DEEPEST)


def _load(name: str, folder: Path, depth: int) -> Hand:
    if name in SHIPPED:
        return SHIPPED[name]()
    if not name.endswith(".toml"):
        hint = nearest(name, SHIPPED)
        raise BadInput(
            f'no hand named "{name}"{hint} (shipped: {", ".join(SHIPPED)}; '
            "or give the path of a hand.toml)"
        )
    if depth == 0:
        raise BadInput(f"{name}: more than {DEEPEST} hand files build on one another, in a circle?")
    path = folder / name
    table = Table.parse(read_text(path), str(path), KEYS)
    return changed(_load(table.text("base", "hannes"), path.parent, depth - 1), table, path.parent)


def read_hand(toml: str, where: str, folder: Path | None = None) -> Hand:
    """Return the hand of a hand.toml's text; `where` stands for the file in messages."""
    table = Table.parse(toml, where, KEYS)
    base = load_hand(table.text("base", "hannes"), folder)
    return changed(base, table, folder)


def changed(hand: Hand, table: Table, folder: Path | None) -> Hand:
    """Return `hand` with the `effects` and `[parameters]` of a table."""
    for name in table.texts("effects"):
        hand = hand.with_effects(_effect(name, table, folder))
    return hand.with_values(values(table.table("parameters"), hand))


def _effect(name: str, table: Table, folder: Path | None) -> Effect:
    try:
        found = catalogue.effect(name, folder)
    except BadInput as error:
        table.refuse("effects", f"cannot be used: {error}")
    if ".py:" in name:
        path, _, attribute = name.rpartition(":")
        _OWN[found] = f"{((folder or Path()) / path).resolve()}:{attribute}"
    return found


def values(table: Table, hand: Hand) -> dict[str, float]:
    """Return SI values by full name from a table of `"full.name" = "value unit"` lines."""
    return {name: value(table, name, hand) for name in table.content}


def value(table: Table, name: str, hand: Hand) -> float:
    """Return the SI value of one parameter, its dimension and bounds checked."""
    return checked(table.content[name], declared(name, hand, table), table)


def checked(given: object, parameter: Parameter, table: Table) -> float:
    """Return the SI value of a text with its unit for `parameter`; BadInput names the file."""
    number = quantity(given, parameter.unit, f"{table.where}: {parameter.name}")
    try:
        return parameter.check(number)
    except BadInput as error:
        raise BadInput(f"{table.where}: {error}") from None


def declared(name: str, hand: Hand, table: Table) -> Parameter:
    """Return a parameter's declaration; BadInput tells an absent effect from a misspelling."""
    prefix = name.partition(".")[0]
    if name == "controller.sampled":
        table.refuse(name, 'is not set here: write controller = "sampled" in the experiment')
    if name not in hand.parameters.declared and prefix in catalogue.effects():
        if prefix not in {each.name for each in hand.effects}:
            table.refuse(name, f'belongs to an effect that is not on: add effects = ["{prefix}"]')
    try:
        return hand.parameters.require(name)
    except BadInput as error:
        raise BadInput(f"{table.where}: {table.prefix[:-1]}: {error}") from None


def hand_toml(hand: Hand) -> str:
    """Return the text of a hand.toml: effects and the values that differ from the shipped hand."""
    import tomli_w

    content = {
        "base": "hannes",
        "effects": effect_names(hand),
        "parameters": texts(hand, differences(hand)),
    }
    return tomli_w.dumps(content)


def differences(hand: Hand) -> dict[str, float]:
    """SI values by full name that are not the shipped hand's, effects at their declared value."""
    return {
        name: number
        for name, number in hand.parameters.items()
        if number != hand.parameters.declared[name].value
    }


def texts(hand: Hand, numbers: Mapping[str, float]) -> dict[str, str]:
    """Values by full name as texts with their unit."""
    return {name: text(x, hand.parameters.require(name).unit) for name, x in numbers.items()}


def effect_names(hand: Hand) -> list[str]:
    """Names under which the effects of `hand` are found again: catalogue, or `file.py:EFFECT`."""
    return [_effect_name(each) for each in hand.effects]


def _effect_name(effect: Effect) -> str:
    if catalogue.effects().get(effect.name) == effect:
        return effect.name
    if effect in _OWN:
        return _OWN[effect]
    function = plain(effect.terms[0].kernel)
    path, found = inspect.getsourcefile(function), function.__globals__
    names = [name for name, held in found.items() if held is effect]
    if not names or not path:
        raise BadInput(f"effect {effect.name} lives in no file, so a hand.toml cannot name it")
    return f"{Path(path).resolve()}:{names[0]}"
