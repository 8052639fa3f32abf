"""Loops: over whole numbers that are the same in all lanes, or until the last lane is through."""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from llvmlite import ir

from hannes.simulation.compiler.lanes.values import Env, NotInLanes, Number, wider
from hannes.simulation.compiler.lanes.ways import Ways

Kind = Any  # of a number (kind, whether it varies), of a tuple a list, else the value itself


@dataclass
class Loop:
    """What a statement within it needs."""

    left: ir.Block
    carried: Mapping[str, Any]  # slots by name
    mask: Number | None  # at its begin
    active: Any = None  # slot of the lanes that have not broken out
    parted: bool = False  # some lanes break out before others


@dataclass
class State:
    """Of the function that is being written."""

    function: ir.Function
    loops: list[Loop] = field(default_factory=list)


@dataclass(frozen=True)
class Turns:
    """A loop's test, what comes before its body, and the name of its count."""

    test: Callable[[Env], Number]
    begin: Callable[[Env], None] = lambda own: None
    count: str = ""


class Loops(Ways):
    """What a loop carries on lies in slots; of which kinds is found by trial."""

    state: State

    @property
    def blocks(self) -> list[ir.Block]:
        """Those of the function that is being written."""
        found: list[ir.Block] = self.state.function.blocks
        return found

    def new_block(self) -> ir.Block:
        """One more block of the function that is being written."""
        return self.state.function.append_basic_block()

    def turns(self, name: str, given: Sequence[Number], body: Sequence[ast.stmt], env: Env) -> None:
        """A loop over whole numbers."""
        if len(given) == 1:
            given = (self.known(0), *given)
        start, stop, step = (*given, self.known(1))[:3]
        if any(x.varying for x in (start, stop, step)) or not step.known:
            raise NotInLanes("a loop of another length in each lane")
        how, count, outer = ast.Lt() if step.known > 0 else ast.Gt(), f"%{name}", env.get(name)
        env[count] = start

        def begin(own: Env) -> None:
            own[name] = own[count]
            own[count] = self.binary(ast.Add(), own[count], step)

        self.loop(Turns(lambda e: self.compare(how, e[count], stop), begin, count), body, env)
        env.pop(count)
        if outer is None:
            env.pop(name, None)

    def loop(self, turns: Turns, body: Sequence[ast.stmt], env: Env) -> None:
        """Body after body while the test holds; written anew where it carries on other kinds."""
        names = sorted((_assigned(body) | {turns.count}) & env.keys())
        kinds, parted = {n: _kind(env[n]) for n in names}, False
        build, mask, state, begun = self.builder, self.mask, self.state, dict(env)
        while True:
            here, done, blocks = build.block, len(build.block.instructions), len(self.blocks)
            found = self._written_loop(turns, body, env, kinds, parted)
            if found == (kinds, parted):
                return
            del self.blocks[blocks:], here.instructions[done:]
            here.terminator = None
            build.position_at_end(here)
            self.mask, self.state = mask, state
            env.clear()
            env.update(begun)
            kinds, parted = found

    def _written_loop(
        self, turns: Turns, body: Sequence[ast.stmt], env: Env, kinds: dict[str, Kind], parted: bool
    ) -> tuple[dict[str, Kind], bool]:
        """Write it for what it is thought to carry on; what it does, and whether lanes part."""
        build, mask = self.builder, self.mask
        slots = {n: self._slot(k) for n, k in kinds.items()}
        active = self._slot(("truth", True)) if parted else None
        for n, slot in slots.items():
            self._put(slot, env[n])
        self._put(active, mask or self.known(True))
        head, inside, after = (self.new_block() for _ in range(3))
        build.branch(head)
        build.position_at_end(head)
        own = dict(env) | {n: self._get(slot) for n, slot in slots.items()}
        before = dict(own)
        truth = turns.test(own)
        some, goes_on = self._lanes(truth, self._get(active) if parted else mask, parted)
        build.cbranch(goes_on.ir, inside, after)
        build.position_at_end(inside)
        self.mask = some
        loop = Loop(after, slots, some, active)
        self._turn(loop, turns, body, own)
        varies = truth.varying or loop.parted
        found = {n: _wider(k, _kind(own[n]), varies and n != turns.count) for n, k in kinds.items()}
        if (found, loop.parted) != (kinds, parted):
            return found, loop.parted
        for n, slot in slots.items():
            of_all = some is None or n == turns.count or not varies
            self._put(slot, own[n] if of_all else self.select(some or truth, own[n], before[n]))
        build.branch(head)
        build.position_at_end(after)
        self.mask = mask
        env.update({n: self._get(slot) for n, slot in slots.items()})
        return kinds, parted

    def _lanes(
        self, truth: Number, mask: Number | None, parted: bool
    ) -> tuple[Number | None, Number]:
        """Lanes that go through the body, and whether there are any."""
        if truth.varying:
            some = truth if mask is None else self.joined(ast.And(), mask, truth)
            return some, self.any_of(some)
        if parted and mask is not None:
            return mask, self.joined(ast.And(), truth, self.any_of(mask))
        return mask, truth

    def _turn(self, loop: Loop, turns: Turns, body: Sequence[ast.stmt], own: Env) -> None:
        self.state.loops.append(loop)
        turns.begin(own)
        if self.block(body, own) is not None:
            raise NotInLanes("a return from within a loop")
        self.state.loops.pop()

    def leave(self, env: Env) -> None:
        """Break out of a loop: all lanes at once, or some."""
        loop = self.state.loops[-1]
        if self.mask is not None and self.mask is not loop.mask:
            loop.parted = True
            if loop.active is not None:
                left = self.opposite(self.mask)
                self._put(loop.active, self.joined(ast.And(), self._get(loop.active), left))
            return
        for n, slot in loop.carried.items():
            self._put(slot, env[n])
        self.builder.branch(loop.left)
        self.builder.position_at_end(self.new_block())

    def _slot(self, kind: Kind) -> Any:
        if isinstance(kind, list):
            return [self._slot(each) for each in kind]
        if not isinstance(kind, tuple):
            return kind
        with self.builder.goto_entry_block():
            return (self.builder.alloca(self.type_of(*kind)), kind)

    def _put(self, slot: Any, value: Any) -> None:
        if isinstance(slot, list):
            for one, part in zip(slot, value, strict=True):
                self._put(one, part)
        elif isinstance(slot, tuple):
            self.builder.store(self.as_kind(value, *slot[1]).ir, slot[0])

    def _get(self, slot: Any) -> Any:
        if isinstance(slot, list):
            return tuple(map(self._get, slot))
        if not isinstance(slot, tuple):
            return slot
        return Number(self.builder.load(slot[0], typ=self.type_of(*slot[1])), *slot[1])


def _kind(value: Any) -> Kind:
    if isinstance(value, Number):
        return (value.kind, value.varying)
    return [_kind(x) for x in value] if isinstance(value, tuple) else value


def _wider(a: Kind, b: Kind, varying: bool) -> Kind:
    if isinstance(a, list) and isinstance(b, list):
        return [_wider(x, y, varying) for x, y in zip(a, b, strict=True)]
    if isinstance(a, tuple) and isinstance(b, tuple):
        return (wider(a[0], b[0]), a[1] or b[1] or varying)
    if a is not b:
        raise NotInLanes("one thing before a loop, another in it")
    return a


def _assigned(body: Sequence[ast.stmt]) -> set[str]:
    return {
        x.id
        for each in body
        for x in ast.walk(each)
        if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)
    }
