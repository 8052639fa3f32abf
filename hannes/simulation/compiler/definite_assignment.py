"""Array channels that a plant's equations have definitely assigned where an effect joins.

The equations are followed in the order in which they run, from one stage into those it calls. A
channel that is filled later, or only where a condition holds, still has what an evaluation before
left in it: an effect must not read that.
"""

import ast
from collections.abc import Sequence

from hannes.core.layout import Layout
from hannes.simulation.compiler.expansion import opened


def assigned_channels(source: str, channels: Layout) -> dict[str, set[str]]:
    """Array channels known where effects join the equations in `source`, by open channel."""
    walk = _Walk(source, channels)
    walk.stage("equations", set())
    for name in walk.stages:
        if name not in walk.entered:
            walk.stage(name, set())  # such as a tick of the firmware: starts anew
    return walk.known


class _Walk:
    def __init__(self, source: str, channels: Layout) -> None:
        tree = ast.parse(source).body
        self.stages = {each.name: each for each in tree if isinstance(each, ast.FunctionDef)}
        self.channels, self.known, self.entered = channels, dict[str, set[str]](), set[str]()
        found = ((line, opened(text)) for line, text in enumerate(source.splitlines(), 1))
        self.openings = {line: opening[1] for line, opening in found if opening}
        starts = [each.lineno for each in self.stages.values()]
        self.ends = dict(zip(self.stages, [*starts[1:], len(source.splitlines()) + 1], strict=True))

    def stage(self, name: str, done: set[str]) -> set[str]:
        """Channels assigned after a stage, where those in `done` were assigned before."""
        self.entered.add(name)
        stage = self.stages[name]
        return self._block(stage.body, (stage.lineno, self.ends[name]), done)

    def _block(
        self, statements: Sequence[ast.stmt], lines: tuple[int, int], done: set[str]
    ) -> set[str]:
        place, end = lines
        for statement in statements:
            self._note(place, statement.lineno, done)
            done, place = self._statement(statement, done), statement.end_lineno or place
        self._note(place, end, done)
        return done

    def _note(self, start: int, end: int, done: set[str]) -> None:
        """Take down what is known where effects join between two lines."""
        for line in range(start, end):
            for channel in self.openings.get(line, ()):
                self.known[channel] = self.known.get(channel, done) & done

    def _statement(self, statement: ast.stmt, done: set[str]) -> set[str]:
        span = statement.lineno, statement.end_lineno or statement.lineno
        if isinstance(statement, ast.If):
            both = [self._block(part, span, done) for part in (statement.body, statement.orelse)]
            return both[0] & both[1]
        if isinstance(statement, ast.For):
            return self._block(statement.body, span, done)
        for call in ast.walk(statement):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name):
                done = self.stage(call.func.id, done) if call.func.id in self.stages else done
        for node in ast.walk(statement):
            done = done | self._filled(node, done)
        return done

    def _filled(self, node: ast.AST, done: set[str]) -> set[str]:
        """The array channel of which `node` sets an element, once all of them are set."""
        match node:
            case ast.Subscript(ast.Attribute(ast.Name("c"), name), place, ast.Store()):
                if not isinstance(place, ast.Constant):
                    return {name}  # the loop's: all of them
                element = f"{name}[{place.value!r}]"
                every = {f"{name}[{k}]" for k in range(self.channels.slot(name).size)}
                return {element, *({name} if every <= {*done, element} else ())}
        return set()
