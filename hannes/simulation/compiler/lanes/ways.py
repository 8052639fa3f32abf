"""Conditions: one way where all lanes agree, else both, and each lane takes what it asked for."""

import ast
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from llvmlite import ir

from hannes.simulation.compiler.lanes.arrays import Arrays
from hannes.simulation.compiler.lanes.library import BUILTIN
from hannes.simulation.compiler.lanes.values import (
    GONE,
    Array,
    Env,
    Gone,
    NotInLanes,
    Number,
    wider,
)

HEAVY = 40  # parts of a way that is left out where no lane goes it
Way = Callable[[Env], Any]


@dataclass(frozen=True)
class Merged:
    """A number that is one of two, from either side."""

    sides: tuple[Number, Number]
    kind: str
    varying: bool


class Ways(Arrays, ABC):
    """Stores are masked where only some lanes go a way."""

    @abstractmethod
    def new_block(self) -> ir.Block:
        """One more block of the function that is being written."""

    @abstractmethod
    def block(self, body: Sequence[ast.stmt], env: Env) -> Any:
        """Run statements in `env`; what they return, or None."""

    def fork(self, test: Number, env: Env, ways: tuple[Way, Way], weights: tuple[int, int]) -> Any:
        """Go the first way where `test` holds, else the second; what that returns."""
        if test.known is not None:
            return ways[not test.known](env)
        if not test.varying:
            return self.parted(test, env, ways)
        if max(weights) <= HEAVY or self.mask is not None:
            return self._both(test, env, ways, weights)
        first = weights[0] > HEAVY  # mostly all lanes go one way
        others = self.any_of(self.opposite(test) if first else test)

        def both(own: Env) -> Any:
            return self._both(test, own, ways, weights)

        return self.parted(others, env, (both, ways[not first]))

    def _both(self, test: Number, env: Env, ways: tuple[Way, Way], weights: tuple[int, int]) -> Any:
        """Go both ways, one after the other."""
        mask, results, envs = self.mask, [], []
        for truth, way, weight in zip((test, self.opposite(test)), ways, weights, strict=True):
            own, after = truth if mask is None else self.joined(ast.And(), mask, truth), dict(env)
            self.mask = own
            if weight > HEAVY:
                results.append(self.parted(self.any_of(own), after, (way, _nothing)))
            else:
                results.append(way(after))
            envs.append(after)
        self.mask = mask
        for name in envs[0].keys() & envs[1].keys():
            env[name] = self.chosen(test, envs[0][name], envs[1][name])
        one, other = results
        if one is None or one is GONE:
            return other
        return one if other is None or other is GONE else self.select(test, one, other)

    def chosen(self, test: Number, one: Any, other: Any) -> Any:
        """Lane by lane the one or the other; where they cannot be, what is gone."""
        try:
            return self.select(test, one, other)
        except NotInLanes:
            return GONE

    def parted(self, test: Number, env: Env, ways: tuple[Way, Way]) -> Any:
        """Go one way, the same in all lanes."""
        build, mask = self.builder, self.mask
        starts, after = (self.new_block(), self.new_block()), self.new_block()
        build.cbranch(test.ir, *starts)
        ends, envs, results = [], [], []
        for start, way in zip(starts, ways, strict=True):
            build.position_at_end(start)
            own = dict(env)
            results.append(way(own))
            self.mask = mask
            ends.append(build.block)
            envs.append(own)
        skipped = results[1] is GONE
        if self.width == 1 and not skipped:
            for own, other in (envs, envs[::-1]):
                own.update({n: self._unknown(x) for n, x in other.items() if n not in own})
        names = [n for n in envs[0] if n in envs[1] or skipped]
        merged = {n: self._common(envs[0][n], envs[1].get(n, GONE), skipped) for n in names}
        result = self._common(results[0], results[1], skipped)
        found = self._joined([*merged.values(), result], ends, after)
        env.update(zip(names, found, strict=False))
        return found[-1]

    def _common(self, a: Any, b: Any, skipped: bool) -> Any:
        """What two values have in common; of a way that may be left out only the first counts."""
        if a is b:
            return a
        if isinstance(a, tuple) and (isinstance(b, tuple) or (b is GONE and skipped)):
            others = b if isinstance(b, tuple) else [GONE] * len(a)
            return tuple(self._common(x, y, skipped) for x, y in zip(a, others, strict=True))
        if isinstance(a, Array) and isinstance(b, Array) and a != b and _alike(a, b):
            return self._common_array(a, b)
        if isinstance(a, Number) and b is GONE and skipped:
            none = ir.Constant(self.type_of(a.kind, a.varying), ir.Undefined)
            return Merged((a, Number(none, a.kind, a.varying)), a.kind, a.varying)
        if isinstance(a, Number) and isinstance(b, Number):
            if a.known is not None and a.kind == b.kind and str(a.known) == str(b.known):
                return a
            return Merged((a, b), wider(a.kind, b.kind), a.varying or b.varying)
        if a is None or b is None:
            return b if a is None else a
        return a if a == b else GONE

    def _unknown(self, value: Any) -> Any:
        """What stands for a value where it was not given: nobody looks at it."""
        if isinstance(value, tuple):
            return tuple(map(self._unknown, value))
        if isinstance(value, Number):
            return Number(ir.Constant(value.ir.type, ir.Undefined), value.kind, value.varying)
        if isinstance(value, Array):
            shape, strides = (
                tuple(x if x.known is not None else self._unknown(x) for x in each)
                for each in (value.shape, value.strides)
            )
            at = ir.Constant(value.at.type, ir.Undefined)
            return replace(value, at=at, shape=shape, strides=strides)
        return value

    def _common_array(self, a: Array, b: Array) -> Array:
        """The one or the other."""
        at = Merged((Number(a.at, "place"), Number(b.at, "place")), "place", False)
        shape = self._common(a.shape, b.shape, False)
        return replace(a, at=at, shape=shape, strides=self._common(a.strides, b.strides, False))

    def _joined(
        self, values: Sequence[Any], ends: Sequence[ir.Block], after: ir.Block
    ) -> list[Any]:
        """End both ways, and take values from either."""
        build, places = self.builder, [m for each in values for m in _places(each)]
        sides: list[list[ir.Value]] = []
        for n, end in enumerate(ends):
            build.position_at_end(end)
            sides.append([self.as_kind(m.sides[n], m.kind, m.varying).ir for m in places])
            build.branch(after)
        build.position_at_end(after)
        found = dict[int, Number]()
        for m, *pair in zip(places, *sides, strict=True):
            phi = build.phi(self.type_of(m.kind, m.varying))
            for value, end in zip(pair, ends, strict=True):
                phi.add_incoming(value, end)
            found[id(m)] = Number(phi, m.kind, m.varying)
        return [_filled(each, found) for each in values]


def _alike(a: Array, b: Array) -> bool:
    """Whether two arrays differ in nothing but their places and sizes."""
    return (len(a.shape), a.kind, a.lanes, a.over) == (len(b.shape), b.kind, b.lanes, b.over)


def _nothing(env: Env) -> Gone:
    return GONE


def _places(value: Any) -> list[Merged]:
    if isinstance(value, tuple):
        return [m for each in value for m in _places(each)]
    if isinstance(value, Array):
        return _places((value.at, value.shape, value.strides))
    return [value] if isinstance(value, Merged) else []


def _filled(value: Any, found: dict[int, Number]) -> Any:
    if isinstance(value, tuple):
        return tuple(_filled(each, found) for each in value)
    if isinstance(value, Array) and isinstance(value.at, Merged):
        shape, strides = _filled(value.shape, found), _filled(value.strides, found)
        return replace(value, at=found[id(value.at)].ir, shape=shape, strides=strides)
    return found[id(value)] if isinstance(value, Merged) else value


def weight(nodes: Sequence[ast.AST]) -> int:
    """How much there is to do in them, about."""
    total = 0
    for each in (part for node in nodes for part in ast.walk(node)):
        if isinstance(each, ast.For | ast.While) or (
            isinstance(each, ast.Call) and not _small(each)
        ):
            total += HEAVY + 1
        total += isinstance(each, ast.BinOp | ast.Subscript | ast.Call)
    return total


def _small(call: ast.Call) -> bool:
    return isinstance(call.func, ast.Name) and call.func.id in BUILTIN
