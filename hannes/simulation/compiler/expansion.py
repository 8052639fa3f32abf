"""Slots and effects expanded into the text of written equations.

Names of slots become subscripts of plain arrays. In place of each statement
`a, b = effects(a, b)` stand the calls of the effects that add to these channels.
"""

import ast
import re
from dataclasses import replace

from hannes.core.effect import Effect, Term
from hannes.core.errors import BadInput
from hannes.core.layout import Layout, Slot

_SLOT = re.compile(r"\b(p|y|dy|c|out)\.([a-z]\w*)")
_ELEMENT = re.compile(r"\b(p|y|dy|c|out)\[(\d+):\d+\]\[")
_OPENING = re.compile(r"^(\s*)(\S.*?) = (?:open_to_)?effects\((.+)\)$")


def opened(line: str) -> tuple[str, list[str]] | None:
    """Indentation and channels of a statement `a, b = effects(a, b)`, None of any other line.

    Raises BadInput where the two sides differ: what is added would be lost.
    """
    found = _OPENING.match(line)
    if found is None:
        return None
    if found[2] != found[3]:
        raise BadInput(f"`{line.strip()}`: expected the same channels on both sides")
    return found[1], [name.removeprefix("c.") for name in found[2].split(", ")]


class Layouts:
    """A plant's layouts grown by its effects' own parameters and states."""

    def __init__(
        self, p: Layout, y: Layout, c: Layout, out: Layout, effects: tuple[Effect, ...]
    ) -> None:
        self.effects, self.c, self.out = effects, c, out
        self.p = p.extended(
            Slot(effect.full_name(each.name), each.unit, each.doc)
            for effect in effects
            for each in effect.parameters
        )
        self.y = y.extended(
            replace(each, name=f"{effect.name}.{each.name}")
            for effect in effects
            for each in effect.states
        )
        self.by_letter = {"p": self.p, "y": self.y, "dy": self.y, "c": self.c, "out": self.out}

    def sizes(self) -> dict[str, str]:
        """Text of sizes by name, and of the least size of each state for a difference step."""
        steps = [slot.tolerance * 1e3 for slot in self.y.slots for _ in range(slot.size)]
        counts = {
            "PARAMETERS": self.p.size, "STATES": self.y.size,
            "CHANNELS": self.c.size, "OUTPUTS": self.out.size,
        }  # fmt: skip
        return {"steps": f"np.array({steps})", **{name: str(n) for name, n in counts.items()}}

    def expanded(self, source: str) -> str:
        """Return the source with the calls of effects in place and slots as subscripts."""
        lines: list[str] = []
        for line in source.splitlines():
            if (opening := opened(line)) is None:
                lines.append(line)
                continue
            indent, channels = opening
            lines.append(f"{indent}# effects: {', '.join(channels)}")
            lines += [indent + call for call in self._calls(channels)]
        return _flat(_SLOT.sub(self._subscript, "\n".join(lines))) + "\n"

    def _subscript(self, match: re.Match[str]) -> str:
        letter, name = match.groups()
        layout = self.by_letter[letter]
        if name not in layout:
            return match[0]
        return letter + layout.text(name)

    def _calls(self, open_channels: list[str]) -> list[str]:
        return [
            line
            for effect in self.effects
            for term in effect.terms
            if term.writes[0] in open_channels
            for line in self._call(effect, term)
        ]

    def _call(self, effect: Effect, term: Term) -> list[str]:
        target = term.writes[0]
        axis = self.c.slot(target).axis
        index = "[k]" if axis else ""
        arguments = ", ".join(self.argument(name, effect, axis) for name in term.arguments)
        call = f"{effect.kernel_name(term)}({arguments})"
        places = [f"c{self.c.text(name)}{index}" if axis else name for name in term.writes]
        rates = [f"dy{self.y.text(f'{effect.name}.{name}')}{index}" for name in term.states]
        if len(places) + len(rates) == 1:
            body = [f"{places[0]} += {call}"]
        else:
            added = [f"added_{n}" for n in range(len(places))]
            body = [f"{', '.join(added + rates)} = {call}"]
            body += [f"{place} += {value}" for place, value in zip(places, added, strict=True)]
        still = [f"{rate} = 0.0" for rate in rates]
        if axis:
            loop = f"for k in range({self.c.slot(target).size}):"
            body, still = ([loop, *map(_indented, each)] if each else [] for each in (body, still))
        otherwise = ["else:", *map(_indented, still)] if still else []
        return [f"if {self.present(effect)}:", *map(_indented, body), *otherwise]

    def present(self, effect: Effect) -> str:
        """Condition, as text, that an effect does not vanish; its kernels need not run else."""
        return " or ".join(
            f"p{self.p.text(effect.full_name(each.name))} != {each.off!r}"
            for each in effect.amplitudes
        )

    def argument(self, name: str, effect: Effect, axis: str) -> str:
        """Text of what one of the kernels of `effect` is given in a loop over `axis`."""
        if f"{effect.name}.{name}" in self.p:
            return "p" + self.p.text(f"{effect.name}.{name}")
        for letter, layout, key in (
            ("y", self.y, f"{effect.name}.{name}"),
            ("p", self.p, name),
            ("y", self.y, name),
        ):
            if key in layout:
                return letter + layout.text(key) + self._element(layout.slot(key), axis)
        if name in self.c and self.c.slot(name).axis:
            return "c" + self.c.text(name) + self._element(self.c.slot(name), axis)
        return name

    @staticmethod
    def _element(slot: Slot, axis: str) -> str:
        """Index of a slot's element in a loop over `axis`."""
        if not slot.axis or not axis:
            return ""
        same = {"phalanx": "joint"}
        if same.get(slot.axis, slot.axis) == same.get(axis, axis):
            return "[k]"
        if slot.axis == "finger":
            return "[k // 2]"
        return ""


def _indented(line: str) -> str:
    return "    " + line


def _flat(text: str) -> str:
    """Turn an element of a slot, `c[5:10][k]`, into one subscript, `c[5 + k]`: no view is made."""
    found = _ELEMENT.search(text)
    if not found:
        return text
    end, depth = found.end(), 1
    while depth:
        depth += {"[": 1, "]": -1}.get(text[end], 0)
        end += 1
    inner = _flat(text[found.end() : end - 1])
    return f"{text[: found.start()]}{found[1]}[{found[2]} + {inner}]" + _flat(text[end:])


def without_outputs(text: str) -> str:
    """Drop the statements that only fill outputs, which the integrator does not need."""
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if isinstance(node, ast.Assign | ast.AugAssign) and _is_output(targets[0]):
            for number in range(node.lineno - 1, node.end_lineno or node.lineno):
                lines[number] = ""
    return "\n".join(lines) + "\n"


def output_read_back(source: str) -> str:
    """Name of an output that equations in `source` read, or nothing."""
    tree = ast.parse(source)
    targets = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store)
    }
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(ast.Name("out"), name, ast.Load()) if id(node) not in targets:
                return name
    return ""


def _is_output(target: ast.AST | None) -> bool:
    while isinstance(target, ast.Subscript):
        target = target.value
    return isinstance(target, ast.Name) and target.id == "out"
