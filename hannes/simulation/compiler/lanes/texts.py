"""Functions as text by name, and what makes the code that is made of them what it is."""

import ast
import functools
import hashlib
import inspect
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from hannes.simulation.compiler.lanes.values import Text
from hannes.simulation.rodas import lockstep, own_steps

# What text of which nothing is known may end in.
ODD = (AttributeError, LookupError, OverflowError, RecursionError, TypeError, ValueError)
APART = ("linearise_at", "factor_border_at")  # written once, and called


@functools.cache
def own_digest() -> str:
    """Of all that writes instructions."""
    text = inspect.getsource(lockstep) + inspect.getsource(own_steps)
    digest = hashlib.sha256(text.encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def functions_of(module: ModuleType) -> str:
    """Text of a module from its first function on."""
    text = inspect.getsource(module)
    return text[text.index("\ndef ") :]


def _stays(node: ast.FunctionDef) -> bool:
    """Whether it stays a function of its own."""
    return node.name in APART or "routine" in map(ast.unparse, node.decorator_list)


def texts_of(module: ModuleType) -> dict[str, Text]:
    """Functions of a generated module."""
    return by_name(Path(str(module.__file__)).read_text(encoding="utf-8"), vars(module))


def by_name(source: str, names: Mapping[str, Any]) -> dict[str, Text]:
    """Functions of a text by name; long ones that are called from several places stay functions."""
    return {
        node.name: Text(node, names, _stays(node))
        for node in ast.parse(source).body
        if isinstance(node, ast.FunctionDef)
    }
