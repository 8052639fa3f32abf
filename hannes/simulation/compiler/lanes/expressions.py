"""Expressions: what text stands for in terms of numbers and arrays."""

import ast
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from hannes.simulation.compiler.lanes.loops import Loops
from hannes.simulation.compiler.lanes.values import (
    TYPES,
    Array,
    Env,
    NotInLanes,
    Number,
    Record,
)
from hannes.simulation.compiler.lanes.ways import weight

PADDED = (12, 10)  # elements that arrays of joints are stored with, and those that are there


class Expressions(Loops):
    """`switches`: places of parameters that are the same in all lanes."""

    switches: frozenset[int]
    constants: dict[int, tuple[Array, np.ndarray]]

    @abstractmethod
    def called(self, node: ast.Call, env: Env) -> Any:
        """What a call gives."""

    def truth(self, node: ast.expr, env: Env) -> Number:
        """A condition."""
        return self.as_kind(self.value(node, env), "truth")

    def value(self, node: ast.expr, env: Env) -> Any:
        """What an expression stands for."""
        match node:
            case ast.Constant(bool() | int() | float() as known):
                return self.known(known)
            case ast.Name(name):
                return env[name] if name in env else self.named(env["%names"].get(name), name)
            case ast.Attribute(of, name):
                return self.attribute(of, name, env)
            case ast.Tuple(parts):
                return tuple(self.value(each, env) for each in parts)
            case ast.Subscript():
                return self.element(node, env)
            case ast.Call(_, _, []):
                return self.called(node, env)
            case ast.IfExp(test, then, other):
                ways = (lambda e: self.value(then, e)), (lambda e: self.value(other, e))
                return self.fork(
                    self.truth(test, env), env, ways, (weight([then]), weight([other]))
                )
        return self.operation(node, env)

    def operation(self, node: ast.expr, env: Env) -> Any:
        """Arithmetic, comparisons, and what joins truths."""
        match node:
            case ast.BinOp(left, how, right):
                return self.binary(how, self.number(left, env), self.number(right, env))
            case ast.UnaryOp(ast.USub(), of):
                return self.minus(self.number(of, env))
            case ast.UnaryOp(ast.UAdd(), of):
                return self.number(of, env)
            case ast.UnaryOp(ast.Not(), of):
                return self.opposite(self.truth(of, env))
            case ast.BoolOp(how, parts):
                found = self._truth_of(self.value(parts[0], env))
                for each in parts[1:]:
                    found = self._further(how, found, each, env)
                return found
            case ast.Compare(left, hows, parts):
                values = [self.number(x, env) for x in (left, *parts)]
                found = self.known(True)
                for comparison, a, b in zip(hows, values, values[1:], strict=False):
                    found = self.joined(ast.And(), found, self.compare(comparison, a, b))
                return found
        raise NotInLanes(ast.unparse(node))

    def number(self, node: ast.expr, env: Env) -> Number:
        """An expression that stands for a number."""
        found = self.value(node, env)
        if not isinstance(found, Number):
            raise NotInLanes(f"{ast.unparse(node)} is no number")
        return found

    def _truth_of(self, found: Any) -> Number:
        if not isinstance(found, Number) or found.kind != "truth":
            raise NotInLanes("`and` or `or` of what is neither true nor false")
        return found

    def _further(self, how: ast.boolop, found: Number, node: ast.expr, env: Env) -> Number:
        """What is on the right is looked at only where that matters."""
        if found.known is not None and bool(found.known) == isinstance(how, ast.Or):
            return found
        reads = any(isinstance(x, ast.Subscript) for x in ast.walk(node))
        if found.varying or found.known is not None or not reads:
            return self.joined(how, found, self._truth_of(self.value(node, env)))
        ways = (lambda e: self._truth_of(self.value(node, e))), (lambda e: found)
        return self.parted(found, env, ways if isinstance(how, ast.And) else ways[::-1])

    def named(self, found: Any, name: str) -> Any:
        """A constant by name."""
        if isinstance(found, bool | int | float | np.generic):
            return self.known(found.item() if isinstance(found, np.generic) else found)
        if isinstance(found, np.ndarray):
            if id(found) not in self.constants:
                self.constants[id(found)] = self.constant(found), found
            return self.constants[id(found)][0]
        raise NotInLanes(f"the name {name}")

    def attribute(self, of: ast.expr, name: str, env: Env) -> Any:
        """Field of a record, size of an array, constant of a module."""
        if isinstance(of, ast.Name) and of.id not in env:
            return self.named(getattr(env["%names"].get(of.id), name, None), name)
        whole = self.value(of, env)
        if isinstance(whole, Record):
            return self.field(whole, name)
        if isinstance(whole, Array) and name == "size":
            if whole.over and len(whole.shape) == 1 and whole.shape[0].known == PADDED[0]:
                return self.known(PADDED[1])
            found = self.known(1)
            for each in whole.shape:
                found = self.binary(ast.Mult(), found, each)
            return found
        if isinstance(whole, Array) and name == "shape":
            return whole.shape
        raise NotInLanes(name)

    def places(self, node: ast.Subscript, env: Env) -> tuple[Array, list[Any]]:
        """An array, and where in it."""
        whole = self.value(node.value, env)
        if not isinstance(whole, Array):
            raise NotInLanes(ast.unparse(node))
        places: list[Any] = []
        for each in node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]:
            if isinstance(each, ast.Slice):
                ends = (each.lower, each.upper)
                places.append(tuple(None if x is None else self.number(x, env) for x in ends))
            else:
                places.append(self.number(each, env))
        return whole, places

    def element(self, node: ast.Subscript, env: Env) -> Any:
        """One number, or a part."""
        if isinstance(whole := self.value(node.value, env), tuple):
            place = self.number(node.slice, env).known
            if place is None:
                raise NotInLanes(ast.unparse(node))
            return whole[int(place)]
        if isinstance(whole, Record):  # the only one of its array
            return whole
        array, places = self.places(node, env)
        if any(isinstance(x, Number) and x.varying for x in places):
            return self.gathered(array, places)
        found = self.part(array, places)
        if found.shape:
            return found
        own = isinstance(node.value, ast.Name) and node.value.id == "p"
        if own and places[0].known in self.switches:
            return Number(self.builder.load(found.at, typ=TYPES[found.kind]), found.kind)
        return self.read(found)

    def sum_of(self, array: Any) -> Number:
        """Sum of a row whose size is known."""
        if not isinstance(array, Array) or len(array.shape) != 1 or array.shape[0].known is None:
            raise NotInLanes("sum")
        total = self.known(0.0)
        for k in range(int(array.shape[0].known)):
            total = self.binary(ast.Add(), total, self.read(self.part(array, [self.known(k)])))
        return total

    def all_of(self, given: Sequence[ast.expr], env: Env) -> list[Any]:
        """Values of arguments."""
        values: list[Any] = []
        for each in given:
            if isinstance(each, ast.Starred):
                values += self.value(each.value, env)
            else:
                values.append(self.value(each, env))
        return values
