"""Which statements of a plant's equations an output needs, so that no other runs for it.

A statement of `equations`, mostly the call of a stage, is needed where it writes what a needed one
reads, in local names or in slots of plain arrays. `a += b` counts as a write alone: whatever else
writes to `a` is needed with it.
"""

import ast
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from hannes.layout import Layout

_ARRAYS = ("c", "dy", "out")
_ANY = "*"
Place = tuple[str, str]  # array and start of a slot, or nothing and a local name


@dataclass
class _Touched:
    reads: set[Place] = field(default_factory=set)
    writes: set[Place] = field(default_factory=set)


@dataclass(frozen=True)
class Needed:
    """What each statement of `equations` reads and writes."""

    statements: tuple[_Touched, ...]
    outputs: Layout

    @staticmethod
    def of(text: str, outputs: Layout) -> "Needed":
        """Read the filled text of all stages."""
        functions = {e.name: e for e in ast.parse(text).body if isinstance(e, ast.FunctionDef)}
        touched: dict[str, _Touched] = {}
        found = []
        for statement in _statements(functions["equations"]):
            visitor = _Visitor(functions, touched, {"t", "y", "p", "reference", "hold"})
            visitor.visit(statement)
            found.append(visitor.found)
        return Needed(tuple(found), outputs)

    def by(self, columns: Iterable[int]) -> np.ndarray:
        """Mask of the statements that these outputs need, shape (statements,)."""
        places = [self.outputs[slot.name] for slot in self.outputs.slots]
        starts = [place.start for k in columns for place in places if place.start <= k < place.stop]
        wanted: set[Place] = {("out", str(start)) for start in starts}
        needed, grown = np.zeros(len(self.statements), np.bool_), True
        while grown:
            grown = False
            for n, each in enumerate(self.statements):
                if not needed[n] and _meet(each.writes, wanted):
                    needed[n], grown = True, True
                    wanted |= each.reads
        return needed


def gated(text: str) -> str:
    """The same text, where `equations` takes which of its statements are to run."""
    functions = {e.name: e for e in ast.parse(text).body if isinstance(e, ast.FunctionDef)}
    lines, equations = text.splitlines(), functions["equations"]
    for n, statement in reversed(list(enumerate(_statements(equations)))):
        first, last = statement.lineno - 1, statement.end_lineno or statement.lineno
        lines[first:last] = [f"    if needed[{n}]:", *("    " + row for row in lines[first:last])]
    head = equations.lineno - 1
    lines[head] = re.sub(r"\):$", ", needed):", lines[head])
    return "\n".join(lines) + "\n"


def _statements(function: ast.FunctionDef) -> list[ast.stmt]:
    return function.body[ast.get_docstring(function) is not None :]


def _meet(some: set[Place], others: set[Place]) -> bool:
    if some & others:
        return True
    whole = {array for array, start in some if start == _ANY}
    whole |= {array for array, start in others if start == _ANY}
    return any({array} & {a for a, _ in some} & {a for a, _ in others} for array in whole)


class _Visitor(ast.NodeVisitor):
    """Gather what a statement touches; of what it calls, the slots alone."""

    def __init__(
        self, functions: dict[str, ast.FunctionDef], known: dict[str, _Touched], given: set[str]
    ) -> None:
        self.functions, self.known, self.given = functions, known, given
        self.found = _Touched()

    def visit_Call(self, node: ast.Call) -> None:
        """Join what a stage touches; its arrays are passed on as they are."""
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in self.functions:
            self.generic_visit(node)
            return
        inner = self._stage(name)
        self.found.reads |= inner.reads
        self.found.writes |= inner.writes
        for each in node.args:
            if not (isinstance(each, ast.Name) and each.id in _ARRAYS):
                self.visit(each)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        """Note one slot."""
        if isinstance(node.value, ast.Name) and node.value.id in _ARRAYS:
            self._note((node.value.id, _start(node.slice)), node.ctx)
            self.visit(node.slice)
        else:
            self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        """Pass over the size of an array."""
        if not (isinstance(node.value, ast.Name) and node.attr == "size"):
            self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        """Note a local name; an array that is handed to what is not known is all touched."""
        if node.id in _ARRAYS:
            self.found.reads.add((node.id, _ANY))
            self.found.writes.add((node.id, _ANY))
        elif node.id not in self.given:
            self._note(("", node.id), node.ctx)

    def _note(self, place: Place, context: ast.expr_context) -> None:
        found = self.found.reads if isinstance(context, ast.Load) else self.found.writes
        found.add(place)

    def _stage(self, name: str) -> _Touched:
        if name not in self.known:
            visitor = _Visitor(self.functions, self.known, self.given)
            for statement in self.functions[name].body:
                visitor.visit(statement)
            self.known[name] = _Touched(
                *({place for place in part if place[0]} for part in _parts(visitor.found))
            )
        return self.known[name]


def _parts(found: _Touched) -> tuple[set[Place], set[Place]]:
    return found.reads, found.writes


def _start(index: ast.expr) -> str:
    """First number of a subscript such as 7, 7:12 or 7 + k: where its slot begins."""
    if isinstance(index, ast.Slice):
        index = index.lower or index
    while isinstance(index, ast.BinOp):
        index = index.left
    return str(index.value) if isinstance(index, ast.Constant) else _ANY
