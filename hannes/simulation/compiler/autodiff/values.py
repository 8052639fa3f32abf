"""Numbers with their derivatives, arrays, and kernels whose derivatives are written by hand."""

import ast
import functools
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

Column = Any


class NotDifferentiable(Exception):
    """The text has something that has no derivative here."""


@dataclass(frozen=True)
class Value:
    """A number as text, its derivatives that may differ from zero, and itself where known."""

    text: str
    derivatives: Mapping[Column, str] = field(default_factory=dict)
    number: int | float | None = None


@dataclass(frozen=True)
class Array:
    """A plain array, or a part of it."""

    name: str
    start: int = 0


@dataclass(frozen=True)
class Written:
    """A kernel whose derivatives are written by hand: by which arguments."""

    derivatives: Callable[..., Any]
    by: tuple[str, ...]


@functools.cache
def tree(function: Callable[..., Any]) -> ast.FunctionDef:
    """What a function is written in; raise NotDifferentiable where that is not at hand."""
    try:
        found = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError) as error:
        raise NotDifferentiable("no text") from error
    if not isinstance(found, ast.FunctionDef):
        raise NotDifferentiable("no function")
    return found


def number(value: float) -> Value:
    """A number that is known."""
    known = int(value) if isinstance(value, int) else float(value)
    return Value(repr(known), {}, known)


def is_active(value: Any) -> bool:
    """Whether a value may depend on the inputs of the differentiation."""
    if isinstance(value, tuple):
        return any(map(is_active, value))
    return not isinstance(value, Value) or bool(value.derivatives)


def results(function: Callable[..., Any]) -> int:
    """How many numbers a function returns; 0 where it returns one, not a tuple."""
    for each in ast.walk(tree(function)):
        if isinstance(each, ast.Return):
            return len(each.value.elts) if isinstance(each.value, ast.Tuple) else 0
    return 0
