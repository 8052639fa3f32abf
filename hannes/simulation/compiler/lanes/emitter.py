"""From text to instructions for all lanes: statements and calls.

The text is that of numba's subset that the models are written in: numbers, arrays, loops,
conditions, calls of other functions of that kind. What is not known here is refused.
"""

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from llvmlite import ir

from hannes.core.kernels.jit import fused, plain, power_of_two
from hannes.core.kernels.pointers import address, numbers_at, pointer, shaped, unknown
from hannes.simulation.compiler.autodiff.values import NotDifferentiable, tree
from hannes.simulation.compiler.lanes.expressions import Expressions
from hannes.simulation.compiler.lanes.library import BUILTIN, of_library
from hannes.simulation.compiler.lanes.loops import State, Turns
from hannes.simulation.compiler.lanes.returns import body_of
from hannes.simulation.compiler.lanes.values import (
    POINTER,
    TYPES,
    Array,
    Env,
    NotInLanes,
    Number,
    Record,
    Text,
)
from hannes.simulation.compiler.lanes.ways import weight
from hannes.simulation.rodas.lockstep import any_lane, of_lane

ROOM = 4096  # numbers of an array that a function makes: they lie on the stack
_FILL_ROW = ast.parse("place[i] = value").body
_FILL = ast.parse("place[i][:] = value").body
_SAME = (pointer, shaped, unknown)  # hand on what they are given


class Emitter(Expressions):
    """Writes functions of `texts` into a module."""

    def __init__(
        self, module: ir.Module, width: int, texts: Mapping[str, Text], switches: Sequence[int] = ()
    ) -> None:
        super().__init__(module, width)
        self.texts, self.switches, self.constants = texts, frozenset(switches), {}
        self.made: dict[Any, tuple[ir.Function, str]] = {}
        self.single = width == 1

    def block(self, body: Sequence[ast.stmt], env: Env) -> Any:
        """Run statements in `env`; what they return, or None."""
        for n, each in enumerate(body):
            match each:
                case ast.Return(value):
                    return () if value is None else self.value(value, env)
                case ast.If(test, then, other):
                    ends = _ends(each)
                    rest = body[n + 1 :] if ends else []
                    parts = [*then, *rest], [*other, *rest]
                    ways = tuple(lambda e, part=part: self.block(part, e) for part in parts)
                    weights = weight(parts[0]), weight(parts[1])
                    result = self.fork(self.truth(test, env), env, (ways[0], ways[1]), weights)
                    if ends:
                        return result
                case ast.Break():
                    self.leave(env)
                    return None
                case _:
                    self.statement(each, env)
        return None

    def statement(self, each: ast.stmt, env: Env) -> None:
        """One that returns nothing."""
        match each:
            case ast.Assign([target], value):
                self.assign(target, self.value(value, env), env)
            case ast.AugAssign(target, how, value):
                read = ast.parse(ast.unparse(target), mode="eval").body
                both = ast.BinOp(read, how, value)
                self.assign(target, self.value(both, env), env)
            case ast.Expr(ast.Call() as call):
                self.value(call, env)
            case ast.Expr(ast.Constant()) | ast.Pass():
                pass
            case ast.For(ast.Name(name), ast.Call(ast.Name("range"), given), body, []):
                self.turns(name, [self.number(x, env) for x in given], body, env)
            case ast.While(test, body, []):
                self.loop(Turns(lambda e: self.truth(test, e)), body, env)
            case _:
                raise NotInLanes(ast.unparse(each).splitlines()[0])

    def assign(self, target: ast.expr, value: Any, env: Env) -> None:
        """Give a name or a place its value."""
        match target:
            case ast.Name(name):
                env[name] = value
            case ast.Tuple(parts) if isinstance(value, tuple) and len(value) == len(parts):
                for part, one in zip(parts, value, strict=True):
                    self.assign(part, one, env)
            case ast.Subscript() if isinstance(value, Number):
                place = self.part(*self.places(target, env))
                if place.shape:
                    inner = {**env, "place": place, "value": value}
                    body = _FILL_ROW if len(place.shape) == 1 else _FILL
                    self.turns("i", place.shape[:1], body, inner)
                else:
                    self.write(place, value)
            case _:
                raise NotInLanes(ast.unparse(target))

    def called(self, node: ast.Call, env: Env) -> Any:
        """What a call gives."""
        names, function = env["%names"], None
        if node.keywords:
            raise NotInLanes("arguments by name")
        match node.func:
            case ast.Attribute(of, "sum") if not node.args:
                return self.sum_of(self.value(of, env))
            case ast.Name(name):
                function = names.get(name, BUILTIN.get(name))
                text = self.texts.get(name)
                if text is not None and (name not in names or names is text.names):
                    function = text
                else:
                    function = self.texts.get(_full_name(function), function)
            case ast.Attribute(ast.Name(module), name) if module in names:
                function = getattr(names[module], name, None)
        return self.apply(function, self.all_of(node.args, env))

    def apply(self, function: Any, values: list[Any]) -> Any:
        """Call something with values."""
        if isinstance(function, Text):
            if function.tree.name == any_lane.__name__:
                return self.any_of(self.as_kind(values[0], "truth"))
            if function.tree.name == of_lane.__name__:
                return self.of_lane(values[0], values[1])
            return (
                self.apart(function, values) if function.called else self.inline(function, values)
            )
        if function in _SAME:
            return self.kept_from(function, values) if self.single else values[0]
        if function is address:
            return Number(self.builder.ptrtoint(values[0].at, TYPES["whole"]), "whole")
        if function is np.zeros:
            return self.room(values[0])
        if function is numbers_at:
            at = self.builder.inttoptr(values[0].ir, POINTER)
            return self.rows(at, values[1], "real", False)
        if function is fused:
            return self.by_llvm("fma", values)
        if function is power_of_two:
            return self.power_of_two(values[0])
        if of_library(function):
            return self.library(function.__name__, values)
        function = plain(function)
        if not hasattr(function, "__code__"):
            raise NotInLanes(f"a call of {getattr(function, '__name__', function)}")
        try:
            return self.inline(Text(tree(function), function.__globals__), values)
        except NotDifferentiable as error:
            raise NotInLanes(f"{function.__name__}: {error}") from error

    def inline(self, text: Text, values: Sequence[Any]) -> Any:
        """What a function gives, written out here."""
        names = [each.arg for each in text.tree.args.args]
        if len(names) != len(values):
            raise NotInLanes("arguments left out")
        env: Env = {"%names": text.names} | dict(zip(names, values, strict=True))
        return self.block(body_of(text.tree), env)

    def kept_from(self, function: Any, values: Sequence[Any]) -> Any:
        """What `pointers.py` keeps from the compiler, of a single grasp."""
        if function is unknown:
            return Number(self.hidden(values[0].ir), "whole")
        place = values[0]
        if function is pointer:
            return Array(place.at, (), (), place.kind, place.lanes)
        return self.rows(self.hidden(place.at), values[1], place.kind, place.lanes)

    def room(self, shape: Any) -> Array:
        """Zeros that live as long as the function."""
        sizes = [n.known for n in (shape if isinstance(shape, tuple) else (shape,))]
        if not self.single or None in sizes or np.prod(sizes) > ROOM:
            raise NotInLanes("an array made anew")
        with self.builder.goto_entry_block():
            at = self.builder.alloca(TYPES["real"], int(np.prod(sizes)))
        made = self.rows(at, sizes, "real", False)
        body = _FILL_ROW if len(sizes) == 1 else _FILL
        env = {"place": made, "value": self.known(0.0), "%names": dict[str, Any]()}
        self.turns("i", made.shape[:1], body, env)
        return made

    def forgotten(self, value: Any) -> Any:
        """A single grasp's functions are one for all the numbers that they are given."""
        if self.single and isinstance(value, Number):
            return Number(value.ir, value.kind)
        return value

    def apart(self, text: Text, values: Sequence[Any]) -> Any:
        """A call of a function of its own, written when it is first called so."""
        given: list[ir.Value] = []
        values = [self.forgotten(each) for each in values]
        keys = [_key(each, given) for each in values]
        key = (id(text.tree), tuple(keys), self.mask is not None)
        if self.mask is not None:
            given.append(self.mask.ir)
        if key not in self.made:
            here, state, mask = self.builder.block, self.state, self.mask
            self.made[key] = self.written(text, keys, [each.type for each in given])
            self.state, self.mask = state, mask
            self.builder.position_at_end(here)
        function, kind = self.made[key]
        word = Number(self.builder.call(function, given), "whole")
        if kind == "real":
            return Number(self.builder.bitcast(word.ir, TYPES["real"]), kind)
        return word if kind == "whole" else self.as_kind(word, kind)

    def written(
        self, text: Text, keys: Sequence[Any], types: Sequence[ir.Type], name: str = ""
    ) -> tuple[ir.Function, str]:
        """Write a function that returns a number, of the kind that is found, in a word."""
        kind = ir.FunctionType(TYPES["whole"], types)
        own = name or self.module.get_unique_name(text.tree.name)
        function, masked = ir.Function(self.module, kind, own), self.mask is not None
        if not name:
            function.linkage = "internal"
            function.attributes.add("noinline")
        self.state = State(function)
        self.builder.position_at_end(self.new_block())
        given = iter(function.args)
        values = [self._made(key, given) for key in keys]
        self.mask = Number(next(given), "truth", True) if masked else None
        found = self.inline(text, values)
        found = self.known(0) if found in (None, ()) else found
        if not isinstance(found, Number) or found.varying:
            raise NotInLanes(f"{text.tree.name} returns something else than a number")
        word = found.ir
        if found.kind == "real":
            word = self.builder.bitcast(word, TYPES["whole"])
        self.builder.ret(word if found.kind != "truth" else self.as_kind(found, "whole").ir)
        return function, found.kind

    def _made(self, key: Any, given: Iterator[ir.Value]) -> Any:
        """What a function takes."""
        match key:
            case ("number", kind, varying, None):
                return Number(next(given), kind, varying)
            case ("number", _, _, known):
                return self.known(known)
            case ("array", shape, strides, *rest):
                at = next(given)
                sizes, steps = (
                    tuple(self._made(x, given) for x in part) for part in (shape, strides)
                )
                return Array(at, sizes, steps, *rest)
            case ("record", fields):
                return Record(next(given), dict(fields))
            case ("tuple", parts):
                return tuple(self._made(x, given) for x in parts)
        raise NotInLanes(str(key))


def _ends(node: ast.stmt) -> bool:
    """Whether a statement may return, or break out of the loop that it is in."""
    if isinstance(node, ast.Return | ast.Break):
        return True
    inner = [*getattr(node, "body", []), *getattr(node, "orelse", [])]
    if isinstance(node, ast.For | ast.While):
        return any(isinstance(x, ast.Return) for x in ast.walk(node))
    return any(map(_ends, inner))


def _full_name(function: Any) -> str:
    own = plain(function)
    return f"{getattr(own, '__module__', '')}.{getattr(own, '__name__', '')}"


def _key(value: Any, given: list[ir.Value]) -> Any:
    """What is the same for all calls of one written function; what differs goes to `given`."""
    match value:
        case Number():
            if value.known is None:
                given.append(value.ir)
            return ("number", value.kind, value.varying, value.known)
        case Array():
            given.append(value.at)
            sizes, steps = (
                tuple(_key(x, given) for x in part) for part in (value.shape, value.strides)
            )
            return ("array", sizes, steps, value.kind, value.lanes, value.over)
        case Record():
            given.append(value.at)
            return ("record", tuple(value.fields.items()))
        case tuple():
            return ("tuple", tuple(_key(x, given) for x in value))
    raise NotInLanes(f"{value} is handed on")
