"""hand.toml of any plant: base, effects, and the parameters that differ from the shipped ones."""

import json
import tomllib
from pathlib import Path
from typing import Any

from hannes import units
from hannes.catalogue import effect as find_effect
from hannes.errors import BadInput, nearest
from hannes.plant import Plant

KEYS = ("base", "effects", "parameters")
BASES = {"hand": "hannes"}  # other plants go by their own name


def base_name(plant: Plant) -> str:
    """What `base` says for this plant."""
    return BASES.get(plant.name, plant.name)


def read_toml(path: Path) -> dict[str, Any]:
    """Return a TOML file's content; BadInput with the line where it is none."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{path} is no TOML: {error}") from None


def with_plant_file(plant: Plant, path: Path) -> Plant:
    """Return `plant` with the effects and values of a hand.toml; BadInput names what is wrong."""
    content = read_toml(path)
    for key in content:
        if key not in KEYS:
            raise BadInput(f'{path}: unknown key "{key}"{nearest(key, KEYS)}')
    base = content.get("base", base_name(plant))
    if base != base_name(plant):
        raise BadInput(
            f'{path}: base = "{base}", but the campaign\'s plant has base "{base_name(plant)}"'
        )
    try:
        return _filled(plant, content, path)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _filled(plant: Plant, content: dict[str, Any], path: Path) -> Plant:
    names = content.get("effects", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise BadInput('effects: expected a list of names, such as ["leader_slack"]')
    grown = plant.with_effects(*(find_effect(name, path.parent) for name in names))
    table = content.get("parameters", {})
    if not isinstance(table, dict):
        raise BadInput("parameters: expected a table of names and values with unit")
    values = {
        name: units.quantity(text, grown.parameters.require(name).unit, name)
        for name, text in table.items()
    }
    return grown.with_values(values)


def plant_toml(plant: Plant, shipped: Plant, effects: list[str]) -> str:
    """Text of a hand.toml that makes `plant` from `shipped`; `effects` as they can be found."""
    lines = [f"base = {json.dumps(base_name(plant))}", f"effects = {json.dumps(effects)}", ""]
    lines += ["[parameters]"]
    for name, value in plant.parameters.items():
        if name not in shipped.parameters.declared or shipped.parameters[name] != value:
            unit = plant.parameters.declared[name].unit
            lines.append(f"{json.dumps(name)} = {json.dumps(units.text(value, unit))}")
    return "\n".join(lines) + "\n"
