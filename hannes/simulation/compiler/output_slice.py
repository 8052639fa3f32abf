"""Which statements of a plant's equations an output needs, so that no other runs for it.

A statement of `equations`, mostly the call of a stage, is needed where it writes what a needed one
reads, in local names or in slots of plain arrays. `a += b` counts as a write alone: whatever else
writes to `a` is needed with it. Text in which that cannot be followed, such as an array by another
name, runs as a whole.
"""

import ast
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from hannes.core.layout import Layout

_ARRAYS = ("c", "dy", "out")
_GIVEN = {"t", "y", "p", "reference", "memory"}
_READING = {"sum", "max", "min", "mean", "size"}  # of an array
_ANY = "*"
Place = tuple[str, str]  # array and start of a slot, or nothing and a local name


@dataclass
class _Touched:
    """odd: it is written in a way that is not followed."""

    reads: set[Place] = field(default_factory=set)
    writes: set[Place] = field(default_factory=set)
    odd: bool = False


@dataclass(frozen=True)
class ProgramSlice:
    """What each statement of `equations` reads and writes; none where that is not followed."""

    statements: tuple[_Touched, ...]
    outputs: Layout

    @staticmethod
    def of(text: str, outputs: Layout) -> "ProgramSlice":
        """Read the expanded text of all stages."""
        found = _touched(text)
        return ProgramSlice(() if _odd(found) else tuple(found), outputs)

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


def guarded(text: str) -> str:
    """The same text, where `equations` takes which of its statements are to run."""
    lines, equations = text.splitlines(), _functions(text)["equations"]
    first, last = equations.lineno - 1, equations.end_lineno or equations.lineno
    statements, odd = _statements(equations), _odd(_touched(text))
    equations.args.args.append(ast.arg("needed"))
    if not odd:
        kept = equations.body[: len(equations.body) - len(statements)]
        equations.body = [*kept, *(_guarded(n, each) for n, each in enumerate(statements))]
    lines[first:last] = ast.unparse(equations).splitlines()
    return "\n".join(lines) + "\n"


def _guarded(number: int, statement: ast.stmt) -> ast.stmt:
    return ast.If(ast.parse(f"needed[{number}]", mode="eval").body, [statement], [])


def _functions(text: str) -> dict[str, ast.FunctionDef]:
    return {each.name: each for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)}


def _touched(text: str) -> list[_Touched]:
    """What each statement of `equations` touches."""
    functions, known, found = _functions(text), dict[str, _Touched](), []
    for statement in _statements(functions["equations"]):
        visitor = _Visitor(functions, known)
        visitor.visit(statement)
        visitor.found.odd |= any(isinstance(e, ast.Return | ast.Raise) for e in ast.walk(statement))
        found.append(visitor.found)
    return found


def _odd(found: list[_Touched]) -> bool:
    """Whether a statement is not followed, or a local name is given twice: it may change type."""
    names = [place for each in found for place in each.writes if not place[0]]
    return any(each.odd for each in found) or len(names) > len(set(names))


def _statements(function: ast.FunctionDef) -> list[ast.stmt]:
    return function.body[ast.get_docstring(function) is not None :]


def _meet(some: set[Place], others: set[Place]) -> bool:
    """Whether a place is in both, or a whole array in one and anything of it in the other."""
    whole = {array for array, start in some | others if start == _ANY}
    in_both = {array for array, _ in some} & {array for array, _ in others}
    return bool(some & others or whole & in_both)


class _Visitor(ast.NodeVisitor):
    """Gather what a statement touches; of what it calls, the slots alone."""

    def __init__(self, functions: dict[str, ast.FunctionDef], known: dict[str, _Touched]) -> None:
        self.functions, self.known, self.found = functions, known, _Touched()

    def visit_Call(self, node: ast.Call) -> None:
        """Join what a stage touches; its arrays are passed on as they are."""
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        self.found.odd |= any(map(_is_part, [*node.args, *(e.value for e in node.keywords)]))
        if name not in self.functions:
            self.generic_visit(node)
            return
        inner, taken = self._stage(name), [each.arg for each in self.functions[name].args.args]
        self.found.reads |= inner.reads
        self.found.writes |= inner.writes
        self.found.odd |= inner.odd or bool(node.keywords) or len(taken) != len(node.args)
        for each, own in zip(node.args, taken, strict=False):
            name = each.id if isinstance(each, ast.Name) else ""
            self.found.odd |= (name in _ARRAYS or own in _ARRAYS) and name != own
            if name not in _ARRAYS:
                self.visit(each)

    def visit_Assign(self, node: ast.Assign) -> None:
        """Take a part of an array by another name for what is not followed."""
        self.found.odd |= _is_part(node.value)
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        """Note one slot."""
        if isinstance(node.value, ast.Name) and node.value.id in _ARRAYS:
            self._note((node.value.id, _start(node.slice)), node.ctx)
            self.visit(node.slice)
        else:
            self.found.odd |= not isinstance(node.ctx, ast.Load)
            self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        """Pass over the size of an array; what else it can do may change it."""
        self.found.odd |= _is_part(node.value) and node.attr not in _READING
        if not (isinstance(node.value, ast.Name) and node.attr == "size"):
            self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        """Note a local name; an array that is handed to what is not known is all touched."""
        if node.id in _ARRAYS:
            self.found.reads.add((node.id, _ANY))
            self.found.writes.add((node.id, _ANY))
        elif node.id not in _GIVEN:
            self._note(("", node.id), node.ctx)
        else:
            self.found.odd |= not isinstance(node.ctx, ast.Load)

    def _note(self, place: Place, context: ast.expr_context) -> None:
        found = self.found.reads if isinstance(context, ast.Load) else self.found.writes
        found.add(place)

    def _stage(self, name: str) -> _Touched:
        if name not in self.known:
            visitor = _Visitor(self.functions, self.known)
            for statement in self.functions[name].body:
                visitor.visit(statement)
            reads, writes = (
                {place for place in part if place[0]}
                for part in (visitor.found.reads, visitor.found.writes)
            )
            self.known[name] = _Touched(reads, writes, visitor.found.odd)
        return self.known[name]


def _is_part(node: ast.AST) -> bool:
    """Whether it is several numbers of an array that is written to."""
    match node:
        case ast.Subscript(ast.Name(name), ast.Slice()):
            return name in _ARRAYS
    return False


def _start(index: ast.expr) -> str:
    """First number of a subscript such as 7, 7:12 or 7 + k: where its slot begins."""
    if isinstance(index, ast.Slice):
        index = index.lower or index
    while isinstance(index, ast.BinOp):
        index = index.left
    return str(index.value) if isinstance(index, ast.Constant) else _ANY
