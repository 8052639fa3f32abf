"""`[[finger]]` tables of a hand's file: what one finger has for itself, by the finger's name.

    [[finger]]
    name = "index"
    mcp_moment_arm = "10.4 mm"        # or "104 %", of the arm that all MCP joints have
    mcp_spring_stiffness = "70 %"
    end_mcp = "1.5 rad"

A joint's value is given with its unit, or as a share of the one that all joints of its kind have.
"""

from collections.abc import Iterator, Mapping
from decimal import Decimal

from hannes.core.errors import BadInput, nearest
from hannes.core.io.toml_table import Table
from hannes.core.io.units import quantity, text
from hannes.core.model import Model
from hannes.core.parameter import Parameter
from hannes.simulation.hand import anatomy, joint_shares
from hannes.simulation.hand.anatomy import FINGERS

KEY = "finger"
_OWN = {each.name for each in (*anatomy.PARAMETERS, *joint_shares.PARAMETERS)}
NAMES = {name for name in _OWN if name.partition(".")[0] in FINGERS}


def finger_values(table: Table, model: Model) -> dict[str, float]:
    """SI values by full name of all `[[finger]]` tables; BadInput names the file and the key."""
    found: dict[str, float] = {}
    for each in _tables(table, model):
        finger = each.choice("name", FINGERS)
        for key, given in each.content.items():
            if key != "name":
                found.update([_value(each, f"{finger}.{key}", key, given, model, found)])
    return found


def _tables(table: Table, model: Model) -> Iterator[Table]:
    given = table.items(KEY)
    if given and not has_fingers(model):
        table.refuse(KEY, "belongs to a hand, and this plant is none")
    for number, content in enumerate(given):
        if not isinstance(content, dict):
            table.refuse(KEY, "must be tables: a line [[finger]], its keys below")
        yield Table(content, table.where, (), f"{KEY} {number + 1}: ")


def has_fingers(model: Model) -> bool:
    """Whether a model has the five fingers' own values."""
    return model.parameters.keys() >= NAMES


def _value(
    table: Table, name: str, key: str, given: object, model: Model, known: Mapping[str, float]
) -> tuple[str, float]:
    if name not in NAMES:
        keys = [each.partition(".")[2] for each in NAMES if each.startswith(name.split(".")[0])]
        table.refuse(key, f"is nothing that a finger has{nearest(key, keys)}")
    if name in known:
        table.refuse(key, "is given twice for this finger")
    declared = model.parameters.require(name)
    number = _number(table, key, given, declared, model)
    try:
        return name, declared.check(number)
    except BadInput as error:
        raise BadInput(f"{table.where}: {error}") from None


def _number(table: Table, key: str, given: object, declared: Parameter, model: Model) -> float:
    """In the parameter's unit; of a joint's value with its unit the share of the shared one."""
    if not declared.shared or (isinstance(given, str) and given.strip().endswith("%")):
        return quantity(given, declared.unit, table.name(key))
    shared = model.parameters.require(declared.shared)
    common = model.parameters[declared.shared]
    number = quantity(given, shared.unit, table.name(key))
    if common == 0.0:
        table.refuse(key, f"= {given}: {declared.shared} is zero, and a finger has a share of it")
    return number / common


def finger_content(model: Model, numbers: Mapping[str, float]) -> list[dict[str, str]]:
    """Content of the `[[finger]]` tables that hold these values; empty for all but a hand."""
    if not has_fingers(model):
        return []
    tables = []
    for finger in FINGERS:
        own = {
            name.partition(".")[2]: _text(model.parameters.require(name), x)
            for name, x in numbers.items()
            if name in NAMES and name.startswith(f"{finger}.")
        }
        tables += [{"name": finger, **own}] if own else []
    return tables


def _text(declared: Parameter, value: float) -> str:
    """A share in percent, to its last digit; all else with its unit."""
    if not declared.shared:
        return text(value, declared.unit)
    return f"{Decimal(repr(float(value))) * 100} %"
