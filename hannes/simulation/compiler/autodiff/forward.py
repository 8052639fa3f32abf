"""A function followed statement by statement, with the lines for its derivatives.

It is followed as it would run, functions that it calls and loops of known length written out; for
every number it computes, lines compute its derivative by each of the inputs that it depends on, and
by no other. What the rules do not know (a search, a loop that ends by what it finds) is
differenced: that one call, not what stands around it.
"""

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hannes.simulation.compiler.autodiff.calls import Calls
from hannes.simulation.compiler.autodiff.rules import OPERATORS
from hannes.simulation.compiler.autodiff.values import (
    Array,
    NotDifferentiable,
    Value,
    Written,
    number,
)


class Differentiation(Calls):
    """Lines that compute a function and its derivatives.

    `functions` are those of a text that arrays are handed through, `names` what it goes by,
    `written` kernels with derivatives of their own. `store`: elements of arrays that have been
    set, or what to differentiate by.
    """

    def __init__(
        self,
        functions: Mapping[str, ast.FunctionDef],
        names: Mapping[str, Any],
        written: Mapping[Callable[..., Any], Written],
    ) -> None:
        super().__init__(names, written)
        self.functions = functions

    def run(self, function: str, arguments: Sequence[Any]) -> Any:
        """Follow a function of the text; return its value or values."""
        tree = self.functions[function]
        names = [each.arg for each in tree.args.args]
        return self.block(tree.body, dict(zip(names, arguments, strict=True)), self.names)[0]

    def call(self, called: ast.expr, given: list[Any], names: Mapping[str, Any]) -> Any:
        """Follow a function of the text, or a kernel."""
        if isinstance(called, ast.Name) and called.id in self.functions:
            return self.run(called.id, given)
        return super().call(called, given, names)

    def block(
        self, body: Sequence[ast.stmt], env: dict[str, Any], names: Mapping[str, Any]
    ) -> tuple[Any, dict[str, Any]]:
        """Run statements; return what they return, or None, and the variables after them."""
        for place, statement in enumerate(body):
            match statement:
                case ast.Return(value):
                    return (self._value(value, env, names) if value else None), env
                case ast.If(test, then, other):
                    rest = list(body[place + 1 :]) if _returns(statement) else []
                    parts = [*then, *rest], [*other, *rest]
                    result, env = self._fork(test, parts, env, names)
                    if rest or _returns(statement):
                        return result, env
                case ast.For(ast.Name(name), ast.Call(ast.Name("range"), limits), inner, []) if (
                    not _returns(statement)
                ):
                    for k in range(*(self._whole(each, env, names) for each in limits)):
                        env = self.block(inner, {**env, name: number(k)}, names)[1]
                case ast.Assign([target], value):
                    env = self._assign(target, self._value(value, env, names), env, names)
                case ast.AugAssign(target, how, value):
                    read = ast.parse(ast.unparse(target), mode="eval").body
                    both = ast.BinOp(read, how, value)
                    env = self._assign(target, self._value(both, env, names), env, names)
                case ast.Expr(ast.Call() as call):
                    self._value(call, env, names)
                case ast.Expr(ast.Constant()) | ast.Pass():
                    pass
                case _:
                    raise NotDifferentiable(ast.unparse(statement).splitlines()[0])
        return None, env

    def _assign(
        self, target: ast.expr, value: Any, env: dict[str, Any], names: Mapping[str, Any]
    ) -> dict[str, Any]:
        match target:
            case ast.Tuple(parts) if isinstance(value, tuple) and len(value) == len(parts):
                for part, each in zip(parts, value, strict=True):
                    env = self._assign(part, each, env, names)
                return env
            case ast.Name(name):
                return {**env, name: self.held(value)}
            case ast.Subscript(ast.Name(array), place) if isinstance(env.get(array), Array):
                at = env[array]
                self.store[at.name, at.start + self._whole(place, env, names)] = self.held(value)
                return env
        raise NotDifferentiable(ast.unparse(target))

    def _fork(
        self,
        test: ast.expr,
        parts: tuple[Sequence[ast.stmt], Sequence[ast.stmt]],
        env: dict[str, Any],
        names: Mapping[str, Any],
    ) -> tuple[Any, dict[str, Any]]:
        """Run both ways of a condition, and what is common to them after it."""
        condition = self._value(test, env, names)
        if condition.number is not None:
            return self.block(parts[not condition.number], env, names)
        before, store = self.lines, self.store
        ways = []
        for part in parts:
            self.lines, self.store = [], dict(store)
            result, after = self.block(part, dict(env), names)
            ways.append((self.lines, self.store, result, after))
        (ours, first, result, env), (theirs, second, other, env_2) = ways
        both = ours, theirs
        merged = {n: self._merged(env[n], env_2[n], both) for n in env if n in env_2}
        self.store = {
            (name, k): self._merged(
                first.get((name, k), Value(f"{name}[{k}]")),
                second.get((name, k), Value(f"{name}[{k}]")),
                both,
            )
            for name, k in {**first, **second}
        }
        result = self._merged(result, other, both)
        self.lines = before
        self.lines += [f"if {condition.text}:", *("    " + line for line in ours or ["pass"])]
        self.lines += ["else:", *("    " + line for line in theirs or ["pass"])]
        return result, merged

    def _merged(self, one: Any, other: Any, ways: tuple[list[str], list[str]]) -> Any:
        """What is `one` after the first way, the other after the second."""
        if one == other:
            return one
        if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
            return tuple(self._merged(*pair, ways) for pair in zip(one, other, strict=True))
        if not isinstance(one, Value) or not isinstance(other, Value):
            raise NotDifferentiable("one thing here, another there")
        derivatives = {
            column: self._either(
                one.derivatives.get(column, "0.0"), other.derivatives.get(column, "0.0"), ways
            )
            for column in {**one.derivatives, **other.derivatives}
        }
        return Value(self._either(one.text, other.text, ways), derivatives)

    def _either(self, one: str, other: str, ways: tuple[list[str], list[str]]) -> str:
        if one == other:
            return one
        name = self.fresh()
        for text, lines in zip((one, other), ways, strict=True):
            lines.append(f"{name} = {text}")
        return name

    def _value(self, node: ast.expr, env: Mapping[str, Any], names: Mapping[str, Any]) -> Any:
        match node:
            case ast.Constant(bool() | int() | float() as known):
                return number(known)
            case ast.Name(name):
                return env[name] if name in env else self._constant(names.get(name))
            case ast.Attribute(ast.Name(module), name):
                return self._constant(getattr(names.get(module), name, None))
            case ast.Tuple(parts):
                return tuple(self._value(each, env, names) for each in parts)
            case ast.Subscript():
                return self._element(node, env, names)
            case ast.BinOp(left, how, right) if type(how) in OPERATORS:
                return self.binary(how, *(self._value(x, env, names) for x in (left, right)))
            case ast.UnaryOp(ast.USub(), of):
                return self.binary(ast.Mult(), number(-1.0), self._value(of, env, names))
            case ast.UnaryOp(ast.UAdd(), of):
                return self._value(of, env, names)
            case ast.IfExp(test, then, other):
                ways = [ast.Return(then)], [ast.Return(other)]
                return self._fork(test, ways, dict(env), names)[0]
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(ast.Not()):
                return self._condition(node, env, names)
            case ast.Call(called, arguments, []):
                given = [self._value(each, env, names) for each in arguments]
                return self.call(called, given, names)
        raise NotDifferentiable(ast.unparse(node))

    @staticmethod
    def _constant(found: Any) -> Value:
        if not isinstance(found, int | float) or not math.isfinite(found):
            raise NotDifferentiable("not a number")
        return number(found)

    def _whole(self, node: ast.expr, env: Mapping[str, Any], names: Mapping[str, Any]) -> int:
        value = self._value(node, env, names)
        if not isinstance(value, Value) or not isinstance(value.number, int):
            raise NotDifferentiable(f"{ast.unparse(node)} is not known")
        return value.number

    def _element(
        self, node: ast.Subscript, env: Mapping[str, Any], names: Mapping[str, Any]
    ) -> Any:
        whole = self._value(node.value, env, names)
        if isinstance(node.slice, ast.Slice) and isinstance(whole, Array) and node.slice.lower:
            return Array(whole.name, whole.start + self._whole(node.slice.lower, env, names))
        place = self._whole(node.slice, env, names)
        if isinstance(whole, tuple):
            return whole[place]
        if not isinstance(whole, Array):
            raise NotDifferentiable(ast.unparse(node))
        at = whole.start + place
        return self.store.get((whole.name, at), Value(f"{whole.name}[{at}]"))

    def _condition(self, node: ast.expr, env: Mapping[str, Any], names: Mapping[str, Any]) -> Value:
        """A truth, whose derivatives are zero."""
        match node:
            case ast.UnaryOp(ast.Not(), of):
                return Value(f"not ({self._value(of, env, names).text})")
            case ast.BoolOp(how, parts):
                word = " and " if isinstance(how, ast.And) else " or "
                return Value(
                    "(" + word.join(self._value(each, env, names).text for each in parts) + ")"
                )
            case ast.Compare(left, hows, parts):
                texts = [self._value(each, env, names).text for each in (left, *parts)]
                return Value(_compared(texts, hows))
        raise NotDifferentiable(ast.unparse(node))


def _returns(statement: ast.stmt) -> bool:
    return any(isinstance(each, ast.Return) for each in ast.walk(statement))


def _compared(texts: Sequence[str], hows: Sequence[ast.cmpop]) -> str:
    tree = ast.Compare(ast.Name("_"), list(hows), [ast.Name("_")] * len(hows))
    signs = ast.unparse(tree).split("_")[1:-1]
    return texts[0] + "".join(s + t for s, t in zip(signs, texts[1:], strict=True))
