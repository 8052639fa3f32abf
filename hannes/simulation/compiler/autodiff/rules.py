"""Rules of differentiation: lines for an operation and for what it does to derivatives."""

import ast
import functools
import math
import operator
import re
from collections.abc import Callable, Iterable
from typing import Any

from hannes.core.kernels.vector_math import exp_minus_one, soft_sign
from hannes.simulation.compiler.autodiff.values import Column, NotDifferentiable, Value, number

_ATOM = re.compile(r"-?(?:[\w.]+(?:\[\w+\])?|\d[\w.]*e-\d+)")
OPERATORS: dict[type, tuple[str, Callable[..., Any]]] = {
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
    "exp_minus_one": ("exp_minus_one", "1.0 + {v}"),
    "soft_sign": ("soft_sign", "1.0 - {v} * {v}"),
}
# By these names generated text calls them.
LANES = {"exp_minus_one": exp_minus_one, "soft_sign": soft_sign}

_STEPS = {"floor": "math.floor", "ceil": "math.ceil", "round": "round", "int": "int"}
_ALIASES = {"fabs": "abs", "absolute": "abs", "arctan": "atan", "maximum": "max", "minimum": "min"}


class Arithmetic:
    """Lines that compute numbers and their derivatives."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._count = 0

    def fresh(self) -> str:
        """A name that nothing has."""
        self._count += 1
        return f"v{self._count}"

    def named(self, text: str) -> str:
        """The text, or a name for it where it is more than a name or a number."""
        if _ATOM.fullmatch(text):
            return text
        name = self.fresh()
        self.lines.append(f"{name} = {text}")
        return name

    def held(self, value: Any) -> Any:
        """The same under a name."""
        if isinstance(value, tuple):
            return tuple(map(self.held, value))
        if isinstance(value, Value) and value.number is None:
            return Value(self.named(value.text), value.derivatives)
        return value

    def chained(self, parts: Iterable[tuple[str, Value]]) -> dict[Column, str]:
        """Sum of derivatives, each times a factor, under names."""
        terms: dict[Column, list[str]] = {}
        for factor, value in parts:
            for column, slope in value.derivatives.items():
                terms.setdefault(column, []).append(_product(factor, slope))
        return {column: self.named(" + ".join(each)) for column, each in terms.items()}

    def binary(self, how: ast.operator, a: Any, b: Any) -> Value:
        """One number by another."""
        sign, computed = OPERATORS[type(how)]
        if not isinstance(a, Value) or not isinstance(b, Value):
            raise NotDifferentiable("numbers only")
        if a.number is not None and b.number is not None:
            return number(computed(a.number, b.number))
        if sign in "+*" and a.number == (sign == "*"):  # 0 + b, 1 * b
            return b
        if sign in "+-*/" and b.number == (sign in "*/"):
            return a
        if not a.derivatives and not b.derivatives:
            return Value(f"({_closed(a.text)} {sign} {_closed(b.text)})")
        x, y = self.named(a.text), self.named(b.text)
        derivatives = self._rules(sign, a, b, x, y)
        text = derivatives.pop("", None) or f"{_closed(x)} {sign} {_closed(y)}"
        return Value(text if _ATOM.fullmatch(text) else f"({text})", derivatives)

    def _rules(self, sign: str, a: Value, b: Value, x: str, y: str) -> dict[Column, str]:
        """Derivatives of `x sign y`; under "" its text where they need it."""
        if sign in "+-":
            return self.chained([("1.0", a), ("1.0" if sign == "+" else "-1.0", b)])
        if sign == "*":
            return self.chained([(y, a), (x, b)])
        if sign == "/":
            per = self.named(f"1.0 / {_closed(y)}")
            value = self.named(f"{_closed(x)} / {_closed(y)}")
            by = self.named(f"-{value} * {per}") if b.derivatives else ""
            return {**self.chained([(per, a), (by, b)]), "": value}
        if sign == "**" and not b.derivatives:
            less = number(b.number - 1) if b.number is not None else Value(f"({y} - 1.0)")
            power = x if less.number == 1 else f"{_closed(x)} ** {_closed(less.text)}"
            return self.chained([(self.named(f"{_closed(y)} * {power}"), a)])
        if sign == "**":
            value = self.named(f"{_closed(x)} ** {_closed(y)}")
            by = self.named(f"{value} * math.log({x})")
            rise = self.named(f"{y} * {value} / {x}")
            return {**self.chained([(rise, a), (by, b)]), "": value}
        raise NotDifferentiable(sign)

    def library(self, name: str, given: list[Any]) -> Value:
        """A function of math, numpy or Python itself."""
        name = _ALIASES.get(name, name)
        if not all(isinstance(each, Value) for each in given):
            raise NotDifferentiable(name)
        if name in ("min", "max"):
            return functools.reduce(lambda a, b: self._extreme(name, a, b), given)
        if name == "copysign" and len(given) == 2:
            return self._signed(*given)
        if len(given) != 1:
            raise NotDifferentiable(name)
        (x,) = given
        if name in _STEPS:
            return Value(f"{_STEPS[name]}({x.text})")
        if name not in _SMOOTH:
            raise NotDifferentiable(name)
        written, rule = _SMOOTH[name]
        if not x.derivatives:
            known = x.number is not None and written.startswith("math.")
            return number(getattr(math, name)(x.number)) if known else Value(f"{written}({x.text})")
        text = self.named(x.text)
        value = self.named(f"{written}({text})")
        rise = self.named(rule.format(v=value, x=_closed(text)))
        return Value(value, self.chained([(rise, x)]))

    def _extreme(self, name: str, a: Value, b: Value) -> Value:
        """Of two numbers that are equal, that which has derivatives."""
        if not a.derivatives and not b.derivatives:
            return Value(f"{name}({a.text}, {b.text})")
        x, y = self.named(a.text), self.named(b.text)
        sign = (">" if name == "max" else "<") + ("" if b.derivatives else "=")
        first = self.named(f"{x} {sign} {y}")
        ours, theirs = a.derivatives, b.derivatives
        derivatives = {
            column: self.named(
                f"{ours.get(column, '0.0')} if {first} else {theirs.get(column, '0.0')}"
            )
            for column in {**ours, **theirs}
        }
        return Value(f"{name}({x}, {y})", derivatives)

    def _signed(self, size: Value, sign: Value) -> Value:
        x, y = self.named(size.text), self.named(sign.text)
        derivatives = self.chained(
            [(self.named(f"math.copysign(1.0, {x}) * math.copysign(1.0, {y})"), size)]
            if size.derivatives
            else []
        )
        return Value(f"math.copysign({x}, {y})", derivatives)


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
