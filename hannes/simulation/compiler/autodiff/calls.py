"""Calls within a differentiation: followed, taken from written derivatives, or differenced."""

import ast
import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hannes.core.kernels.jit import plain
from hannes.simulation.compiler.autodiff.rules import LANES, Arithmetic
from hannes.simulation.compiler.autodiff.values import (
    Array,
    NotDifferentiable,
    Value,
    Written,
    is_active,
    results,
    tree,
)

_BUILTINS = {"abs": abs, "min": min, "max": max, "round": round, "int": int, "float": float}


class Calls(Arithmetic, ABC):
    """What `names` go by and `written` kernels can be called; see Differentiation."""

    def __init__(
        self, names: Mapping[str, Any], written: Mapping[Callable[..., Any], Written]
    ) -> None:
        super().__init__()
        self.names, self.written = names, written
        self.store: dict[tuple[str, int], Value] = {}

    @abstractmethod
    def block(
        self, body: Sequence[ast.stmt], env: dict[str, Any], names: Mapping[str, Any]
    ) -> tuple[Any, dict[str, Any]]:
        """Run statements; return what they return, or None, and the variables after them."""

    def kernel(self, name: str, arguments: Sequence[Value]) -> Any:
        """Follow a kernel that the text goes by; return its value or values."""
        return self.call(ast.Name(name), list(arguments), self.names)

    def call(self, called: ast.expr, given: list[Any], names: Mapping[str, Any]) -> Any:
        """Follow what is called, by the `names` that hold where it is."""
        function = _found(called, names)
        if _of_library(function):
            return self.library(function.__name__, given)
        function = plain(function)
        if not hasattr(function, "__code__"):
            raise NotDifferentiable(ast.unparse(called))
        outermost = names is self.names
        if outermost and not any(is_active(each) for each in given):
            return self._plainly(ast.unparse(called), function, given)
        lines, before, store = self.lines, list(self.lines), dict(self.store)
        try:
            return self._inlined(function, given)
        except NotDifferentiable:
            if not outermost:
                raise
            lines[:] = before
            self.lines, self.store = lines, store
            return self._differenced(ast.unparse(called), function, given)

    def _inlined(self, function: Callable[..., Any], given: list[Any]) -> Any:
        """Follow a kernel; where many inputs come through few arguments, by these."""
        names = list(inspect.signature(function).parameters)
        if len(names) != len(given):
            raise NotDifferentiable("arguments left out")
        given = [self.held(each) for each in given]
        active = [n for n, each in enumerate(given) if is_active(each)]
        if not all(isinstance(given[n], Value) for n in active):
            return self._follow(function, given)
        rule = self.written.get(function)
        if rule and {names[n] for n in active} <= set(rule.by):
            return self._by_rule(function, rule, dict(zip(names, given, strict=True)))
        if len({column for n in active for column in given[n].derivatives}) <= len(active):
            return self._follow(function, given)
        local = [
            Value(each.text, {n: "1.0"}) if n in active else each for n, each in enumerate(given)
        ]
        found = self._follow(function, local)
        if isinstance(found, tuple):
            return tuple(self._passed_on(each, given) for each in found)
        return self._passed_on(found, given)

    def _by_rule(
        self, function: Callable[..., Any], rule: Written, given: Mapping[str, Any]
    ) -> Value:
        """The value of a kernel whose derivatives are written by hand."""
        bare = [Value(each.text, {}, each.number) for each in given.values()]
        found = self._follow(plain(rule.derivatives), bare)
        rises = found if isinstance(found, tuple) else (found,)
        parts = [
            (self.named(rise.text), given[by]) for rise, by in zip(rises, rule.by, strict=True)
        ]
        return Value(self.held(self._follow(function, bare)).text, self.chained(parts))

    def _passed_on(self, value: Value, given: Sequence[Any]) -> Value:
        """Derivatives by arguments to those by what these depend on."""
        parts = [(rise, given[n]) for n, rise in value.derivatives.items()]
        return Value(value.text, self.chained(parts), value.number)

    def _follow(self, function: Callable[..., Any], given: Sequence[Any]) -> Any:
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        known = dict(zip(function.__code__.co_freevars, cells, strict=True))
        arguments = dict(zip(inspect.signature(function).parameters, given, strict=True))
        return self.block(tree(function).body, arguments, {**function.__globals__, **known})[0]

    def _plainly(self, name: str, function: Callable[..., Any], given: list[Any]) -> Any:
        """Call what depends on none of the inputs."""
        texts = ", ".join(map(self._argument, given))
        many = results(function)
        if not many:
            return Value(self.named(f"{name}({texts})"))
        name_of_all = self.fresh()
        found = [f"{name_of_all}_{k}" for k in range(many)]
        self.lines.append(f"{', '.join(found)} = {name}({texts})")
        return tuple(map(Value, found))

    def _argument(self, value: Any) -> str:
        if isinstance(value, Value):
            return value.text
        if isinstance(value, Array) and value.start == 0:
            if any(name == value.name for name, _ in self.store):
                raise NotDifferentiable(f"all of {value.name}")
            return value.name
        raise NotDifferentiable("part of an array")

    def _differenced(self, name: str, function: Callable[..., Any], given: list[Any]) -> Any:
        """Call it, and again with each active argument a little larger."""
        given = [self.held(each) for each in given]
        base = self._plainly(name, function, given)
        values = base if isinstance(base, tuple) else (base,)
        parts: list[list[tuple[str, Value]]] = [[] for _ in values]
        for n, each in enumerate(given):
            if isinstance(each, Value) and each.derivatives:
                later = self.named(f"{each.text} + 1e-7 * max(abs({each.text}), 1e-3)")
                moved = self._plainly(name, function, [*given[:n], Value(later), *given[n + 1 :]])
                for k, after in enumerate(moved if isinstance(moved, tuple) else (moved,)):
                    rise = f"({after.text} - {values[k].text}) / ({later} - {each.text})"
                    parts[k].append((self.named(rise), each))
        found = tuple(
            Value(value.text, self.chained(part)) for value, part in zip(values, parts, strict=True)
        )
        return found if isinstance(base, tuple) else found[0]


def _found(called: ast.expr, names: Mapping[str, Any]) -> Any:
    """What a call calls."""
    match called:
        case ast.Name(name):
            return names.get(name, _BUILTINS.get(name))
        case ast.Attribute(ast.Name(module), name):
            return getattr(names.get(module), name, None)
    return None


def _of_library(function: Any) -> bool:
    known = type(function).__name__ in ("ufunc", "builtin_function_or_method")
    return known or function in (int, float, *LANES.values())
