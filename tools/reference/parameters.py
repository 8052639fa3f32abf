"""Parameters of the hand, with value, unit, bounds, meaning and source."""

from hannes.core.parameter import Parameter
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.joint_shares import QUANTITIES
from tools.reference.markdown import code, number, table

HEAD = """# Parameters of the hand

These are the names of a `hand.toml` and of `[parameters]` in an experiment.
`hannes hand --values` prints them.
A source "choice" means that nothing is published: the value is of a plausible size.
"""
SHARES = """## A joint's own share

A finger is `index`, `middle`, `ring`, `little` or `thumb`, a joint `mcp` or `pip`.
Each share is 1 unless a `[[finger]]` table says otherwise.
"""


def page() -> str:
    """Text of the page, a section a part."""
    parts: dict[str, list[Parameter]] = {}
    for each in Hand().parameters.declared.values():
        if not each.shared:
            parts.setdefault(each.name.partition(".")[0], []).append(each)
    return "\n".join([HEAD, *(_part(name, rows) for name, rows in parts.items()), _shares()])


def _shares() -> str:
    """What each joint has for itself, a row a quantity: it is the same for all fingers."""
    rows = [
        (
            code(f"<finger>.<joint>_{name}"),
            " to ".join(map(number, bounds)),
            code(f"<joint>.{name}"),
        )
        for name, bounds in QUANTITIES.items()
    ]
    columns = ("name", "bounds", "share of")
    return f"{SHARES}\n{table(columns, rows)}\n"


def _part(name: str, declared: list[Parameter]) -> str:
    rows = [
        (
            code(each.name),
            number(each.value),
            each.unit,
            " to ".join(number(end) for end in each.bounds),
            each.doc,
            each.source,
        )
        for each in declared
    ]
    columns = ("name", "value", "unit", "bounds", "meaning", "source")
    return f"## {name}\n\n{table(columns, rows)}\n"
