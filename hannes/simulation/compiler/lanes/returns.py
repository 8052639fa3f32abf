"""Returns from within loops as conditions: what is compiled knows returns outside loops only."""

import ast
import functools
from collections.abc import Sequence

_LEFT, _FOUND = "%left", "%found"  # whether a loop was left by a return, and what that gives


@functools.lru_cache(maxsize=4096)
def body_of(function: ast.FunctionDef) -> Sequence[ast.stmt]:
    """A function's statements, none of which returns from within a loop."""
    return _outside(function.body)


def _outside(body: Sequence[ast.stmt]) -> list[ast.stmt]:
    found: list[ast.stmt] = []
    for each in body:
        if isinstance(each, ast.For | ast.While) and _returns(each):
            value = ast.Name(_FOUND, ast.Load()) if _gives(each) else None
            found += [_given(_LEFT, False), _given(_FOUND, False)]
            found += [_with(each, _inside(each.body)), _if_left(ast.Return(value))]
        elif isinstance(each, ast.If) and _returns(each):
            found.append(ast.If(each.test, _outside(each.body), _outside(each.orelse)))
        else:
            found.append(each)
    return found


def _inside(body: Sequence[ast.stmt]) -> list[ast.stmt]:
    """Statements of a loop's body."""
    found: list[ast.stmt] = []
    for each in body:
        if isinstance(each, ast.Return):
            given = [] if each.value is None else [_given(_FOUND, each.value)]
            return [*found, *given, _given(_LEFT, True), ast.Break()]
        if isinstance(each, ast.For | ast.While) and _returns(each):
            found += [_with(each, _inside(each.body)), _if_left(ast.Break())]
        elif isinstance(each, ast.If) and _returns(each):
            found.append(ast.If(each.test, _inside(each.body), _inside(each.orelse)))
        else:
            found.append(each)
    return found


def _returns(node: ast.AST) -> bool:
    return any(isinstance(x, ast.Return) for x in ast.walk(node))


def _gives(node: ast.AST) -> bool:
    return any(isinstance(x, ast.Return) and x.value is not None for x in ast.walk(node))


def _with(loop: ast.For | ast.While, body: list[ast.stmt]) -> ast.stmt:
    if isinstance(loop, ast.For):
        return ast.For(loop.target, loop.iter, body, loop.orelse)
    return ast.While(loop.test, body, loop.orelse)


def _given(name: str, value: ast.expr | bool) -> ast.stmt:
    held = ast.Constant(value) if isinstance(value, bool) else value
    return ast.Assign([ast.Name(name, ast.Store())], held)


def _if_left(then: ast.stmt) -> ast.stmt:
    return ast.If(ast.Name(_LEFT, ast.Load()), [then], [])
