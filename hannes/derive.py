"""Derivatives of plain functions by their text: forward mode over what they are written in.

A function is followed statement by statement as it would run, functions that it calls and loops
of known length written out; for every number it computes, lines compute its derivative by each
of the inputs that it hangs on, and by no other. What the derivation does not know (a search, a
loop that ends by what it finds) is differenced: that one call, not what stands around it.
"""

import ast
import functools
import inspect
import math
import operator
import re
import textwrap
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

from hannes._jit import plain

Column = Hashable
_ATOM = re.compile(r"-?(?:[\w.]+(?:\[\w+\])?|\d[\w.]*e-\d+)")
_BINARY: dict[type, tuple[str, Callable[..., Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.Pow: ("**", operator.pow),
    ast.FloorDiv: ("//", operator.floordiv),
    ast.Mod: ("%", operator.mod),
}
# Functions of one number: how they are written, and their derivative by x where the value is v.
_SMOOTH = {
    "exp": ("math.exp", "{v}"),
    "log": ("math.log", "1.0 / {x}"),
    "sqrt": ("math.sqrt", "0.5 / max({v}, 1e-300)"),
    "sin": ("math.sin", "math.cos({x})"),
    "cos": ("math.cos", "-math.sin({x})"),
    "tan": ("math.tan", "1.0 + {v} * {v}"),
    "tanh": ("math.tanh", "1.0 - {v} * {v}"),
    "atan": ("math.atan", "1.0 / (1.0 + {x} * {x})"),
    "abs": ("abs", "math.copysign(1.0, {x})"),
    "float": ("float", "1.0"),
}
_STEPS = {"floor": "math.floor", "ceil": "math.ceil", "round": "round", "int": "int"}
_ALIASES = {"fabs": "abs", "absolute": "abs", "arctan": "atan", "maximum": "max", "minimum": "min"}


class Underivable(Exception):
    """The text has something that has no derivative here."""


@dataclass(frozen=True)
class Value:
    """A number as text, its derivatives that may differ from zero, and itself where known."""

    text: str
    slopes: Mapping[Column, str] = field(default_factory=dict)
    number: float | None = None


@dataclass(frozen=True)
class Array:
    """A plain array, or a part of it."""

    name: str
    start: int = 0


@dataclass(frozen=True)
class Written:
    """A kernel whose derivatives are written by hand: by which arguments."""

    slopes: Callable[..., Any]
    by: tuple[str, ...]


@functools.cache
def _tree(function: Callable[..., Any]) -> ast.FunctionDef:
    try:
        found = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError) as error:
        raise Underivable("no text") from error
    if not isinstance(found, ast.FunctionDef):
        raise Underivable("no function")
    return found


def number(value: float) -> Value:
    """A number that is known."""
    return Value(repr(value), {}, value)


class Derivation:
    """Lines that compute a function and its derivatives.

    `functions` are those of a text that arrays are handed through, `names` what it goes by,
    `written` kernels with derivatives of their own. `cells`: elements of arrays that have been
    set, or what to derive by.
    """

    def __init__(
        self,
        functions: Mapping[str, ast.FunctionDef],
        names: Mapping[str, Any],
        written: Mapping[Callable[..., Any], Written],
    ) -> None:
        self.functions, self.names, self.written = functions, names, written
        self.lines: list[str] = []
        self.cells: dict[tuple[str, int], Value] = {}
        self._count = 0

    def run(self, function: str, arguments: Sequence[Any]) -> Any:
        """Follow a function of the text; return its value or values."""
        tree = self.functions[function]
        names = [each.arg for each in tree.args.args]
        return self._block(tree.body, dict(zip(names, arguments, strict=True)), self.names)[0]

    def kernel(self, name: str, arguments: Sequence[Value]) -> Any:
        """Follow a kernel that the text goes by; return its value or values."""
        return self._call(ast.Name(name), list(arguments), self.names)

    def named(self, text: str) -> str:
        """The text, or a name for it where it is more than a name or a number."""
        if _ATOM.fullmatch(text):
            return text
        self._count += 1
        self.lines.append(f"v{self._count} = {text}")
        return f"v{self._count}"

    # Statements

    def _block(
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
                case ast.For(ast.Name(name), ast.Call(ast.Name("range"), limits), inner):
                    for k in range(*(self._whole(each, env, names) for each in limits)):
                        env = self._block(inner, {**env, name: number(k)}, names)[1]
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
                    raise Underivable(ast.unparse(statement).splitlines()[0])
        return None, env

    def _assign(
        self, target: ast.expr, value: Any, env: dict[str, Any], names: Mapping[str, Any]
    ) -> dict[str, Any]:
        match target:
            case ast.Tuple(parts):
                for part, each in zip(parts, value, strict=True):
                    env = self._assign(part, each, env, names)
                return env
            case ast.Name(name):
                return {**env, name: self._held(value)}
            case ast.Subscript(ast.Name(array), place):
                at = env[array]
                self.cells[at.name, at.start + self._whole(place, env, names)] = self._held(value)
                return env
        raise Underivable(ast.unparse(target))

    def _held(self, value: Any) -> Any:
        """The same under a name."""
        if isinstance(value, tuple):
            return tuple(map(self._held, value))
        if isinstance(value, Value) and value.number is None:
            return Value(self.named(value.text), value.slopes)
        return value

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
            return self._block(parts[not condition.number], env, names)
        before, cells = self.lines, self.cells
        ways = []
        for part in parts:
            self.lines, self.cells = [], dict(cells)
            result, after = self._block(part, dict(env), names)
            ways.append((self.lines, self.cells, result, after))
        (ours, first, result, env), (theirs, second, other, env_2) = ways
        both = ours, theirs
        merged = {n: self._merged(env[n], env_2[n], both) for n in env if n in env_2}
        self.cells = {
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
            raise Underivable("one thing here, another there")
        slopes = {
            column: self._either(one.slopes.get(column, "0.0"), other.slopes.get(column, "0.0"), ways)
            for column in {**one.slopes, **other.slopes}
        }
        return Value(self._either(one.text, other.text, ways), slopes)

    def _either(self, one: str, other: str, ways: tuple[list[str], list[str]]) -> str:
        if one == other:
            return one
        self._count += 1
        for text, lines in zip((one, other), ways, strict=True):
            lines.append(f"v{self._count} = {text}")
        return f"v{self._count}"

    # Expressions

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
            case ast.BinOp(left, how, right) if type(how) in _BINARY:
                return self._binary(how, *(self._value(x, env, names) for x in (left, right)))
            case ast.UnaryOp(ast.USub(), of):
                return self._binary(ast.Mult(), number(-1.0), self._value(of, env, names))
            case ast.UnaryOp(ast.UAdd(), of):
                return self._value(of, env, names)
            case ast.IfExp(test, then, other):
                ways = [ast.Return(then)], [ast.Return(other)]
                return self._fork(test, ways, dict(env), names)[0]
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(ast.Not()):
                return self._condition(node, env, names)
            case ast.Call(called, arguments, []):
                given = [self._value(each, env, names) for each in arguments]
                return self._call(called, given, names)
        raise Underivable(ast.unparse(node))

    @staticmethod
    def _constant(found: Any) -> Value:
        if not isinstance(found, int | float):
            raise Underivable("not a number")
        return number(found) if math.isfinite(found) else Value("np.inf" if found > 0 else "-np.inf")

    def _whole(self, node: ast.expr, env: Mapping[str, Any], names: Mapping[str, Any]) -> int:
        value = self._value(node, env, names)
        if not isinstance(value, Value) or not isinstance(value.number, int):
            raise Underivable(f"{ast.unparse(node)} is not known")
        return value.number

    def _element(self, node: ast.Subscript, env: Mapping[str, Any], names: Mapping[str, Any]) -> Any:
        whole = self._value(node.value, env, names)
        if isinstance(node.slice, ast.Slice) and isinstance(whole, Array) and node.slice.lower:
            return Array(whole.name, whole.start + self._whole(node.slice.lower, env, names))
        place = self._whole(node.slice, env, names)
        if isinstance(whole, tuple):
            return whole[place]
        if not isinstance(whole, Array):
            raise Underivable(ast.unparse(node))
        at = whole.start + place
        return self.cells.get((whole.name, at), Value(f"{whole.name}[{at}]"))

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
        raise Underivable(ast.unparse(node))

    def _binary(self, how: ast.operator, a: Any, b: Any) -> Value:
        sign, computed = _BINARY[type(how)]
        if not isinstance(a, Value) or not isinstance(b, Value):
            raise Underivable("numbers only")
        if a.number is not None and b.number is not None:
            return number(computed(a.number, b.number))
        if sign in "+*" and a.number == (sign == "*"):  # 0 + b, 1 * b
            return b
        if sign in "+-*/" and b.number == (sign in "*/"):
            return a
        if not a.slopes and not b.slopes:
            return Value(f"({a.text} {sign} {b.text})")
        x, y = self.named(a.text), self.named(b.text)
        slopes = self._rules(sign, a, b, x, y)
        text = slopes.pop("", None) or f"{_closed(x)} {sign} {_closed(y)}"
        return Value(text if _ATOM.fullmatch(text) else f"({text})", slopes)

    def _rules(self, sign: str, a: Value, b: Value, x: str, y: str) -> dict[Column, str]:
        """Derivatives of `x sign y`; under "" its text where they need it."""
        if sign in "+-":
            return self._chained([("1.0", a), ("1.0" if sign == "+" else "-1.0", b)])
        if sign == "*":
            return self._chained([(y, a), (x, b)])
        if sign == "/":
            per = self.named(f"1.0 / {_closed(y)}")
            value = self.named(f"{_closed(x)} / {_closed(y)}")
            by = self.named(f"-{value} * {per}") if b.slopes else ""
            return {**self._chained([(per, a), (by, b)]), "": value}
        if sign == "**" and not b.slopes:
            less = number(b.number - 1) if b.number is not None else Value(f"({y} - 1.0)")
            power = x if less.number == 1 else f"{_closed(x)} ** {_closed(less.text)}"
            return self._chained([(self.named(f"{_closed(y)} * {power}"), a)])
        if sign == "**":
            value = self.named(f"{_closed(x)} ** {_closed(y)}")
            by = self.named(f"{value} * math.log({x})")
            rise = self.named(f"{y} * {value} / {x}")
            return {**self._chained([(rise, a), (by, b)]), "": value}
        raise Underivable(sign)

    def _chained(self, parts: Iterable[tuple[str, Value]]) -> dict[Column, str]:
        """Sum of derivatives, each times a factor, under names."""
        terms: dict[Column, list[str]] = {}
        for factor, value in parts:
            for column, slope in value.slopes.items():
                terms.setdefault(column, []).append(_product(factor, slope))
        return {column: self.named(" + ".join(each)) for column, each in terms.items()}

    # Calls

    def _call(self, called: ast.expr, given: list[Any], names: Mapping[str, Any]) -> Any:
        if isinstance(called, ast.Name) and called.id in self.functions:
            return self.run(called.id, given)
        function = _found(called, names)
        name = getattr(function, "__name__", "")
        name = _ALIASES.get(name, name)
        if function in (abs, min, max, round, int, float) or _of_library(function):
            return self._library(name, given)
        function = plain(function)
        if not hasattr(function, "__code__"):
            raise Underivable(ast.unparse(called))
        outermost = names is self.names
        if outermost and not any(_felt(each) for each in given):
            return self._plainly(ast.unparse(called), function, given)
        before = list(self.lines), dict(self.cells)
        try:
            return self._inlined(function, given)
        except Underivable:
            if not outermost:
                raise
            self.lines[:], self.cells = before
            return self._differenced(ast.unparse(called), function, given)

    def _library(self, name: str, given: list[Any]) -> Value:
        if not all(isinstance(each, Value) for each in given):
            raise Underivable(name)
        if name in ("min", "max"):
            return functools.reduce(lambda a, b: self._extreme(name, a, b), given)
        if name == "copysign" and len(given) == 2:
            return self._signed(*given)
        (x,) = given
        if name in _STEPS:
            return Value(f"{_STEPS[name]}({x.text})")
        if name not in _SMOOTH:
            raise Underivable(name)
        written, rule = _SMOOTH[name]
        if not x.slopes:
            known = x.number is not None and written.startswith("math.")
            return number(getattr(math, name)(x.number)) if known else Value(f"{written}({x.text})")
        text = self.named(x.text)
        value = self.named(f"{written}({text})")
        rise = self.named(rule.format(v=value, x=_closed(text)))
        return Value(value, self._chained([(rise, x)]))

    def _extreme(self, name: str, a: Value, b: Value) -> Value:
        """Of two numbers that are equal, that which has derivatives."""
        if not a.slopes and not b.slopes:
            return Value(f"{name}({a.text}, {b.text})")
        x, y = self.named(a.text), self.named(b.text)
        sign = (">" if name == "max" else "<") + ("" if b.slopes else "=")
        first = self.named(f"{x} {sign} {y}")
        slopes = {
            column: self.named(
                f"{a.slopes.get(column, '0.0')} if {first} else {b.slopes.get(column, '0.0')}"
            )
            for column in {**a.slopes, **b.slopes}
        }
        return Value(f"{name}({x}, {y})", slopes)

    def _signed(self, size: Value, sign: Value) -> Value:
        x, y = self.named(size.text), self.named(sign.text)
        slopes = self._chained(
            [(self.named(f"math.copysign(1.0, {x}) * math.copysign(1.0, {y})"), size)]
            if size.slopes
            else []
        )
        return Value(f"math.copysign({x}, {y})", slopes)

    def _inlined(self, function: Callable[..., Any], given: list[Any]) -> Any:
        """Follow a kernel; where many inputs come through few arguments, by these."""
        names = list(inspect.signature(function).parameters)
        if len(names) != len(given):
            raise Underivable("arguments left out")
        given = [self._held(each) for each in given]
        felt = [n for n, each in enumerate(given) if _felt(each)]
        numbers = all(isinstance(given[n], Value) for n in felt)
        columns = {column for n in felt if numbers for column in given[n].slopes}
        rule = self.written.get(function)
        if rule and numbers and {names[n] for n in felt} <= set(rule.by):
            bare = [Value(each.text, {}, each.number) for each in given]
            rises = self._follow(plain(rule.slopes), bare)
            rises = rises if isinstance(rises, tuple) else (rises,)
            parts = [(self.named(r.text), given[names.index(by)]) for r, by in zip(rises, rule.by, strict=True)]
            return Value(self._held(self._follow(function, bare)).text, self._chained(parts))
        if not numbers or len(columns) <= len(felt):
            return self._follow(function, given)
        local = [
            Value(each.text, {("of", n): "1.0"}) if n in felt else each
            for n, each in enumerate(given)
        ]
        results = self._follow(function, local)
        return self._mapped(results, lambda each: self._passed_on(each, given))

    def _passed_on(self, value: Value, given: list[Any]) -> Value:
        parts = [(rise, given[n]) for (_, n), rise in value.slopes.items()]  # type: ignore[misc]
        return Value(value.text, self._chained(parts), value.number)

    @staticmethod
    def _mapped(results: Any, change: Callable[[Value], Value]) -> Any:
        return tuple(map(change, results)) if isinstance(results, tuple) else change(results)

    def _follow(self, function: Callable[..., Any], given: Sequence[Any]) -> Any:
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        known = dict(zip(function.__code__.co_freevars, cells, strict=True))
        arguments = dict(zip(inspect.signature(function).parameters, given, strict=True))
        return self._block(_tree(function).body, arguments, {**function.__globals__, **known})[0]

    def _plainly(self, name: str, function: Callable[..., Any], given: list[Any]) -> Any:
        """Call what hangs on nothing that is derived by."""
        texts = ", ".join(map(self._argument, given))
        many = _results(function)
        if not many:
            return Value(self.named(f"{name}({texts})"))
        self._count += 1
        found = [f"v{self._count}_{k}" for k in range(many)]
        self.lines.append(f"{', '.join(found)} = {name}({texts})")
        return tuple(map(Value, found))

    def _argument(self, value: Any) -> str:
        if isinstance(value, Value):
            return value.text
        if isinstance(value, Array) and value.start == 0:
            if any(name == value.name for name, _ in self.cells):
                raise Underivable(f"all of {value.name}")
            return value.name
        raise Underivable("part of an array")

    def _differenced(self, name: str, function: Callable[..., Any], given: list[Any]) -> Any:
        """Call it, and again with each argument that is derived by a little larger."""
        given = [self._held(each) for each in given]
        base = self._plainly(name, function, given)
        values = base if isinstance(base, tuple) else (base,)
        parts: list[list[tuple[str, Value]]] = [[] for _ in values]
        for n, each in enumerate(given):
            if isinstance(each, Value) and each.slopes:
                later = self.named(f"{each.text} + 1e-7 * max(abs({each.text}), 1e-3)")
                moved = self._plainly(name, function, [*given[:n], Value(later), *given[n + 1 :]])
                for k, after in enumerate(moved if isinstance(moved, tuple) else (moved,)):
                    rise = f"({after.text} - {values[k].text}) / ({later} - {each.text})"
                    parts[k].append((self.named(rise), each))
        found = tuple(
            Value(value.text, self._chained(part)) for value, part in zip(values, parts, strict=True)
        )
        return found if isinstance(base, tuple) else found[0]


def alive(lines: Sequence[str]) -> list[str]:
    """Drop the lines that compute what nothing needs."""
    needed: set[str] = set()
    kept: list[str] = []
    for line in reversed(lines):
        target = re.match(r"\s*(v\w+(?:, v\w+)*) = ", line)
        if target and not needed & set(target[1].split(", ")):
            continue
        if line.endswith(":") and (not kept or _depth(kept[-1]) <= _depth(line)):
            if line.strip() == "else:" or not kept or kept[-1].strip() != "else:":
                continue
            kept.append(" " * (_depth(line) + 4) + "pass")
        needed |= set(re.findall(r"\bv\d\w*", line[target.end() :] if target else line))
        kept.append(line)
    return kept[::-1]


def _depth(line: str) -> int:
    return len(line) - len(line.lstrip())


def _returns(statement: ast.stmt) -> bool:
    return any(isinstance(each, ast.Return) for each in ast.walk(statement))


def _felt(value: Any) -> bool:
    if isinstance(value, tuple):
        return any(map(_felt, value))
    return not isinstance(value, Value) or bool(value.slopes)


def _compared(texts: Sequence[str], hows: Sequence[ast.cmpop]) -> str:
    tree = ast.Compare(ast.Name("_"), list(hows), [ast.Name("_")] * len(hows))
    signs = ast.unparse(tree).split("_")[1:-1]
    return texts[0] + "".join(s + t for s, t in zip(signs, texts[1:], strict=True))


def _closed(text: str) -> str:
    """Safe as an operand."""
    return f"({text})" if text.startswith("-") else text


def _product(factor: str, slope: str) -> str:
    for one, other in ((factor, slope), (slope, factor)):
        if one == "1.0":
            return other
        if one == "-1.0":
            return f"-{_closed(other)}"
    return f"{_closed(factor)} * {_closed(slope)}"


def _found(called: ast.expr, names: Mapping[str, Any]) -> Any:
    """What a call calls."""
    match called:
        case ast.Name(name):
            builtins = {"abs": abs, "min": min, "max": max, "round": round, "int": int}
            return names.get(name, {**builtins, "float": float}.get(name))
        case ast.Attribute(ast.Name(module), name):
            return getattr(names.get(module), name, None)
    return None


def _of_library(function: Any) -> bool:
    return type(function).__name__ in ("ufunc", "builtin_function_or_method")


def _results(function: Callable[..., Any]) -> int:
    """How many numbers a function returns; 0 where it returns one, not a tuple."""
    for each in ast.walk(_tree(function)):
        if isinstance(each, ast.Return):
            return len(each.value.elts) if isinstance(each.value, ast.Tuple) else 0
    return 0
