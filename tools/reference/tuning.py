"""Tuning constants of the methods, found in the code: fields of dataclasses, and module constants.

A constant's meaning is the comment at the end of its line, or above it; a field's is in the
docstring of its class.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tools.reference.markdown import code, table

PACKAGE = Path(__file__).parents[2] / "hannes"
METHODS = {
    "Diagnosis": "identification/diagnosis",
    "Calibration": "identification/calibration",
    "Hold-out": "identification/holdout",
    "Data check": "campaigns/quality",
    "Recognition": "recognition",
}
HEAD = """# Tuning constants

Numbers that a method depends on, with the file where each stands.
[How a diagnosis works](../explanation/diagnosis.md) explains most of them,
and [Calibration](../explanation/calibration.md) some.
"""


def page() -> str:
    """Text of the page, a section a method."""
    return "\n".join([HEAD, *(_method(name, folder) for name, folder in METHODS.items())])


def _method(name: str, folder: str) -> str:
    rows = [row for file in sorted((PACKAGE / folder).rglob("*.py")) for row in _rows(file)]
    return f"## {name}\n\n{table(('constant', 'value', 'means', 'file'), rows)}\n"


def _rows(file: Path) -> Iterator[tuple[str, str, str, str]]:
    text = file.read_text(encoding="utf-8")
    lines, place = text.splitlines(), file.relative_to(PACKAGE.parent).as_posix()
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and _constant(node):
            (name,) = node.targets
            yield code(ast.unparse(name)), _value(node.value), _comment(lines, node), code(place)
        elif isinstance(node, ast.ClassDef) and node.name.endswith(("Constants", "Tuning")):
            meanings = _meanings(ast.get_docstring(node) or "")
            for each in node.body:
                if isinstance(each, ast.AnnAssign) and each.value is not None:
                    name = ast.unparse(each.target)
                    said = meanings.get(name) or _comment(lines, each)
                    yield code(name), _value(each.value), said, code(place)


def _constant(node: ast.Assign) -> bool:
    """Whether it is NAME = a number, or several."""
    if len(node.targets) != 1 or not isinstance(node.targets[0], ast.Name):
        return False
    name = node.targets[0].id
    leaves = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
    numbers = [each for each in leaves if isinstance(each.value, int | float)]
    calls = any(isinstance(each, ast.Call | ast.Attribute) for each in ast.walk(node.value))
    return name.isupper() and bool(numbers) and len(numbers) == len(leaves) and not calls


def _value(node: ast.expr) -> str:
    return code(ast.unparse(node))


def _comment(lines: list[str], node: ast.Assign | ast.AnnAssign) -> str:
    """At the end of the line, else the lines of comment right above."""
    _, _, said = lines[(node.end_lineno or node.lineno) - 1].partition("  # ")
    above: list[str] = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.strip().startswith("# "):
            break
        above.insert(0, line.strip().removeprefix("# "))
    return said or " ".join(above)


def _meanings(docstring: str) -> dict[str, str]:
    """`name: meaning`, a line or more each."""
    found = re.findall(r"^ *(\w+): +(.*(?:\n {4,}\S.*)*)", docstring, re.MULTILINE)
    return {name: " ".join(said.split()) for name, said in found}
