"""Tuning constants of the methods: fields of their frozen dataclasses, and module constants."""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

from hannes.identification.tunings import METHODS, tables
from tools.reference.markdown import code, table

ROOT = Path(__file__).parents[2]
MODULES = {"Data check": "hannes/campaigns/quality", "Recognition": "hannes/recognition"}
HEAD = """# Tuning constants

Numbers that a method depends on.
[How a diagnosis works](../explanation/diagnosis.md) explains most of them,
and [Calibration](../explanation/calibration.md) some.

"Development seeds" are seeds of `benchmarks.naming`, none of which is quoted in the evidence.
What a campaign may set stands on [Campaign](campaign.md).
"""


def page() -> str:
    """Text of the page, a section a method."""
    parts = [HEAD, _files(), tables()]
    return "\n".join([*parts, *(_modules(name, folder) for name, folder in MODULES.items())])


def _files() -> str:
    """Which file has which dataclass."""
    classes = [type(each) for tunings in METHODS.values() for each in tunings]
    files = [Path(inspect.getfile(each)).relative_to(ROOT).as_posix() for each in classes]
    rows = [(code(each.__name__), code(file)) for each, file in zip(classes, files, strict=True)]
    return f"{table(('class', 'file'), rows)}\n"


def _modules(name: str, folder: str) -> str:
    rows = [row for file in sorted((ROOT / folder).glob("*.py")) for row in _constants(file)]
    return f"## {name}\n\n{table(('constant', 'value', 'meaning', 'file'), rows)}\n"


def _constants(file: Path) -> Iterator[tuple[str, str, str, str]]:
    """NAME = numbers, at the top of a module; its meaning is the comment beside it or above."""
    text, place = file.read_text(encoding="utf-8"), file.relative_to(ROOT).as_posix()
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and _numbers(node):
            name, value = ast.unparse(node.targets[0]), ast.unparse(node.value)
            yield code(name), code(value), _comment(lines, node), code(place)


def _numbers(node: ast.Assign) -> bool:
    """Whether it is NAME = a number, or several."""
    leaves = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
    only = bool(leaves) and all(isinstance(each.value, int | float) for each in leaves)
    calls = any(
        isinstance(each, ast.Call | ast.Attribute | ast.Subscript) for each in ast.walk(node.value)
    )
    return only and not calls and ast.unparse(node.targets[0]).isupper()


def _comment(lines: list[str], node: ast.Assign) -> str:
    """At the end of the line and in those that follow it, else in the lines right above."""
    _, _, said = lines[(node.end_lineno or node.lineno) - 1].partition("  # ")
    above: list[str] = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.startswith("# "):
            break
        above.insert(0, line.removeprefix("# "))
    return said or " ".join(above)
