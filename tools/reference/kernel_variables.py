"""What a kernel may read and add to, plant by plant: from layouts and equations."""

from collections.abc import Iterable, Mapping, Sequence

from hannes.core.layout import Slot
from hannes.plants.protocol import PLANTS, Plant, find_plant
from hannes.simulation.catalogue import named
from hannes.simulation.compiler.open_channels import Open, open_channels
from hannes.simulation.hand.hand_file import own_catalogue
from tools.reference.markdown import code, table

HEAD = """# Variables of a kernel

A kernel's argument names say what it reads.
`writes` of its `Term` says what it adds to.
`hannes effects FILE.py:NAME` refuses what is not on this page, in one line.

A kernel may read these everywhere:

- the effect's own parameters and states, by their names;
- `t`, the time [s];
- the plant's [parameters](parameters.md), with an underscore for the dot: `motor_resistance`;
- the plant's states, listed below.

A variable with an axis is an array, such as one number for each finger.
A kernel that adds along an axis is called once for each element.
It is given that element of arrays along the same axis, and the element of its finger.
A kernel that adds to a single number is given whole arrays.
A kernel must not change what it is given.
"""
VARIABLE = ("name", "unit", "shape", "is")


def page() -> str:
    """Text of the page."""
    return "\n".join([HEAD, *(_plant(find_plant(name)) for name in PLANTS)])


def _plant(plant: Plant) -> str:
    equations = plant.compiled_from  # type: ignore[attr-defined]
    found = list(open_channels(equations))
    groups = _groups(found)
    parts = [f'# Plant "{plant.name}"']
    if equations.states.slots:
        parts += ["## States", table(VARIABLE, map(_variable, equations.states.slots))]
    rows = [[*_variable(each.slot), each.stage, _writers(plant, each)] for each in found]
    parts += ["## Add to", table((*VARIABLE, "stage", "effects that add to it"), rows)]
    parts += ["## Read there", _readable(found, groups)]
    if equations.numbers.slots:
        parts += [
            "## Numbers of the stages",
            table(VARIABLE, map(_variable, equations.numbers.slots)),
        ]
    slots = {slot.name: slot for slot in equations.channels.slots}
    for label, names in groups.items():
        rows = [_variable(slots[name]) for name in names]
        parts += [f"## Arrays {label}", table(VARIABLE, rows)]
    return "\n\n".join(parts) + "\n"


def _variable(slot: Slot) -> list[str]:
    shape = f"{slot.size}, one a {slot.axis}" if slot.axis else "one number"
    return [code(slot.name), slot.unit, shape, slot.doc]


def _writers(plant: Plant, channel: Open) -> str:
    known = named() | dict(own_catalogue(plant))
    names = [
        name
        for name, effect in known.items()
        if not plant.accepts(effect)
        and any(channel.slot.name in term.writes for term in effect.terms)
    ]
    return _list(names) or "none that ships"


def _groups(found: Iterable[Open]) -> dict[str, list[str]]:
    """Letter -> arrays that are known at the same places, so that a table can name them once."""
    places: dict[str, list[str]] = {}
    for each in found:
        for name in each.arrays:
            places.setdefault(name, []).append(each.slot.name)
    together: dict[tuple[str, ...], list[str]] = {}
    for name, where in places.items():
        together.setdefault(tuple(where), []).append(name)
    order = sorted(together, key=lambda where: -len(where))
    return {chr(ord("A") + k): together[where] for k, where in enumerate(order)}


def _readable(found: Iterable[Open], groups: Mapping[str, Sequence[str]]) -> str:
    """Rows of channels that let a kernel read the same stand together."""
    same: dict[tuple[str, str], list[str]] = {}
    for each in found:
        letters = ", ".join(label for label, names in groups.items() if names[0] in each.arrays)
        same.setdefault((letters, _list(each.numbers)), []).append(each.slot.name)
    rows = [[_list(names), numbers, letters] for (letters, numbers), names in same.items()]
    if not groups:
        return table(("adding to", "numbers"), [row[:2] for row in rows])
    return table(("adding to", "numbers", "arrays"), rows)


def _list(names: Iterable[str]) -> str:
    return ", ".join(map(code, names))
