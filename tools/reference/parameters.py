"""Parameters of the hand, with value, unit, bounds, meaning and source."""

from hannes.core.parameter import Parameter
from hannes.simulation.hand.hand import Hand
from tools.reference.markdown import code, number, table

HEAD = """# Parameters of the hand

These are the names of a `hand.toml` and of `[parameters]` in an experiment.
`hannes hand --values` prints them.
A source "choice" means that nothing is published: the value is of a plausible size.
"""


def page() -> str:
    """Text of the page, a section a part."""
    parts: dict[str, list[Parameter]] = {}
    for each in Hand().parameters.declared.values():
        parts.setdefault(each.name.partition(".")[0], []).append(each)
    return "\n".join([HEAD, *(_part(name, rows) for name, rows in parts.items())])


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
