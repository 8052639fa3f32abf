"""From a plant's written equations and a list of effects to compiled entry points.

The equations stay the text they are: names of slots become subscripts, lines that name open
channels are followed by the calls of effects, and lines that only fill outputs are dropped
from the version that the integrator runs.
"""

import ast
import functools
import hashlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from hannes import full
from hannes._jit import cache_folder, entry, inner, plain, routine
from hannes.effect import Effect, Term
from hannes.errors import BadInput
from hannes.files import write_text
from hannes.layout import Layout, Slot
from hannes.rodas import text as method
from hannes.rodas.problem import Problem

_SLOT = re.compile(r"\b(p|y|dy|c|out)\.([a-z]\w*)")
_ELEMENT = re.compile(r"\b(p|y|dy|c|out)\[(\d+):\d+\]\[")
_HOOK = re.compile(r"^(\s*)# effects: (.+)$")

_OPEN = "workspace|advance|first_step|sample_pieces"
_CLOSED = (
    "equations|step|attempt|linearise|decompose|resolve|"
    "motor_stages|wire_stages|joints|contact|press|inertia|factor_rest"
)

_ENTRIES = '''

@entry
def rates(t, y, p, reference, hold):
    dy = np.zeros({states})
    equations(t, y, dy, p, np.zeros({channels}), reference, hold, np.zeros({outputs}))
    return dy


@entry
def jacobian(t, y, p, reference, hold):
    """df/dy as the integrator has it."""
    data, rates = workspace(y, p, reference, hold), np.zeros({states})
    slope(t, y, rates, data)
    linearise(t, y, rates, np.zeros({states}), data)
    columns = np.zeros(({states}, {states}))
    gather(data, columns)
    return columns


@entry
def differences(t, y, p, reference, hold):
    """df/dy by forward differences, one column a state."""
    c, out, moved = np.zeros({channels}), np.zeros({outputs}), y.copy()
    base, dy, columns = np.zeros({states}), np.zeros({states}), np.zeros(({states}, {states}))
    equations(t, moved, base, p, c, reference, hold, out)
    for j in range({states}):
        moved[j] += 1e-7 * max(abs(y[j]), steps[j])
        equations(t, moved, dy, p, c, reference, hold, out)
        columns[:, j] = (dy - base) / (moved[j] - y[j])
        moved[j] = y[j]
    return columns


@entry
def tick(t, y, p, reference, hold):
    scratch = np.zeros({states})
    sample(t, y, scratch, p, np.zeros({channels}), reference, hold, np.zeros({outputs}))
'''

_FIRMWARE = '''

@entry
def firmware(
    data, y, rtol, atol, period, duration, counts, work, times, rows, holds
):
    """Tick after tick of the sampled controller; returns how many samples were reached."""
    p, reference, hold, c, out, dy, _ = data[0]
    ends, pieces, clock = np.zeros(65), np.zeros((64, 4, y.size)), np.zeros(5)
    filled = 0
    for k in range(int(np.ceil(duration / period - 1e-9))):
        start, end = k * period, min((k + 1) * period, duration)
        sample(start, y, dy, p, c, reference, hold, out)
        clock[:] = (start, end - start, end, period, 1.0)
        while clock[0] != end:
            taken = advance(data, y, rtol, atol, clock, counts, ends, pieces, work)
            if taken == 0:
                return filled
            last = filled
            before = ends[taken] * (1.0 - 1e-12) if ends[taken] == end else ends[taken]
            while last < times.size and times[last] < before:
                last += 1
            sample_pieces(times[filled:last], ends[: taken + 1], pieces[:taken], rows[filled:last])
            for row in range(filled, last):
                holds[row] = hold
            filled = last
    if filled < times.size:
        rows[filled] = y
        holds[filled] = hold
        filled += 1
    return filled
'''

_OBSERVED = """

@entry
def observe(times, states, p, reference, holds):
    rows = np.zeros((times.size, {outputs}))
    for k in range(times.size):
        dy, c = np.zeros({states}), np.zeros({channels})
        equations(times[k], states[k], dy, p, c, reference, holds[k], rows[k])
    return rows
"""


@dataclass(frozen=True)
class Shape:
    """How a plant's Jacobian is differenced and solved.

    `module` holds the text; `constants` its constants; `written` further text; `broken` says why
    the shape does not hold with these effects, or nothing.
    """

    module: ModuleType
    constants: dict[str, str]
    written: str
    broken: str


@dataclass(frozen=True, eq=False)
class Equations:
    """A plant's written equations: the module that holds them and what its slots mean.

    `entries` is the text of further entry points of its own, a template like `_ENTRIES`.
    `shape(states, channels, stage_of, effects)` finds the Shape of a plant that has one.
    """

    module: ModuleType
    parameters: Layout
    states: Layout
    channels: Layout
    outputs: Layout
    entries: str = ""
    shape: Callable[..., Shape] | None = None

    def source(self) -> str:
        """Text of the module's functions, without its imports and head."""
        return _functions(self.module)

    def stage_of(self, channel: str) -> str:
        """Name of the written function whose hook is open for `channel`."""
        stage = ""
        for line in self.source().splitlines():
            if line.startswith("def "):
                stage = line[4 : line.index("(")]
            if (hook := _HOOK.match(line)) and channel in hook[2].split(", "):
                return stage
        return ""

    def accepts(self, effect: Effect) -> str:
        """Return why this plant cannot carry `effect`, or an empty string where it can."""
        for term in effect.terms:
            for channel in term.writes:
                if not self.stage_of(channel):
                    return f"it needs a channel {channel}, which this plant does not have"
            for name in term.arguments:
                if not self._known(name, effect, term):
                    return f"it reads {name}, which this plant does not have"
        return ""

    def _known(self, name: str, effect: Effect, term: Term) -> bool:
        own = {each.name for each in effect.parameters} | {each.name for each in effect.states}
        if name in own or name == "t" or name in self.parameters or name in self.states:
            return True
        return name in self.channels or name in self._locals(term.writes[0])

    def _locals(self, channel: str) -> set[str]:
        """Names bound in the stage of `channel` before its hook."""
        stage, bound = self.stage_of(channel), set()
        function = getattr(self.module, stage)
        for line in inspect.getsource(function).splitlines():
            if (hook := _HOOK.match(line)) and channel in hook[2].split(", "):
                break
            if assigned := re.match(r"^    ([\w, ]+?) (?:=|\+=) ", line):
                bound |= set(assigned[1].split(", "))
        return bound | set(inspect.signature(function).parameters)


@dataclass(frozen=True, eq=False)
class Compiled:
    """Entry points of one plant with one set of effects; see the names in `_ENTRIES`."""

    text: str
    parameters: Layout
    states: Layout
    outputs: Layout
    fast: ModuleType
    observed: ModuleType
    jacobian_kind: str = "dense differences"

    def problem(self, p: np.ndarray, reference: np.ndarray, hold: np.ndarray) -> Problem:
        """The rates with these parameters as a problem for `Rodas`."""
        fast = self.fast
        data = fast.workspace(np.zeros(self.states.size), p, reference, hold)
        return Problem(fast.advance, fast.first_step, fast.sample_pieces, data)

    def is_warm(self, entry: str = "rates") -> bool:
        """Tell whether machine code of a former run can be used for an entry point."""
        folder = Path(str(self.fast.__file__)).parent / "__pycache__"
        stem = Path(str(self.fast.__file__)).stem
        return any(folder.glob(f"{stem}.{entry}*.nbi"))


def assemble(plant: Equations, effects: Iterable[Effect] = ()) -> Compiled:
    """Compile `plant` with `effects`; the same set is assembled once per process.

    Raises BadInput where an effect does not fit the plant.
    """
    return _assembled(plant, tuple(effects))


@functools.cache
def _assembled(plant: Equations, effects: tuple[Effect, ...]) -> Compiled:
    for effect in effects:
        if why := plant.accepts(effect):
            raise BadInput(f"effect {effect.name} does not fit: {why}")
    layouts = _Layouts(plant, effects)
    text = layouts.fill(plant.source())
    quick = _without_outputs(text)
    kernels = {
        f"{effect.name}_{plain(term.kernel).__name__}": term.kernel
        for effect in effects
        for term in effect.terms
    }
    solution, kind = _solution(plant, layouts, effects)
    names = {**vars(plant.module), **vars(solution.module), **method.NAMES, **kernels}
    reached = [each for each in names.values() if hasattr(plain(each), "__code__")]
    origin = "".join(_fingerprint(each) for each in reached)
    quick += layouts.fill(_functions(solution.module)) + solution.written + method.source()
    quick += layouts.sized(_ENTRIES + _FIRMWARE + plant.entries)
    return Compiled(
        text,
        layouts.p,
        layouts.y,
        layouts.out,
        _module("fast", quick, names, origin, solution.constants),
        _module("observed", text + layouts.sized(_OBSERVED), names, origin, {}),
        kind,
    )


def _solution(
    plant: Equations, layouts: "_Layouts", effects: tuple[Effect, ...]
) -> tuple[Shape, str]:
    """How to difference and solve, and what to call it."""
    sizes = {
        "steps": f"np.array({layouts.steps()})",
        "CHANNELS": str(layouts.c.size),
        "OUTPUTS": str(layouts.out.size),
    }
    dense = Shape(full, sizes, "", "")
    if plant.shape is None:
        return dense, "dense differences"
    shape = plant.shape(layouts.y, layouts.c, plant.stage_of, effects)
    if shape.broken:
        return dense, f"dense differences, because {shape.broken}"
    return replace(shape, constants=sizes | shape.constants), "structured"


def _functions(module: ModuleType) -> str:
    """Text of a module from its first function on."""
    text = inspect.getsource(module)
    first = next(node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef))
    return "\n".join(text.splitlines()[first.lineno - 1 :]) + "\n"


class _Layouts:
    """The plant's layouts grown by its effects' own parameters and states."""

    def __init__(self, plant: Equations, effects: tuple[Effect, ...]) -> None:
        self.effects, self.c, self.out = effects, plant.channels, plant.outputs
        self.p = plant.parameters.extended(
            Slot(effect.full_name(each.name), each.unit, each.doc)
            for effect in effects
            for each in effect.parameters
        )
        self.y = plant.states.extended(
            replace(each, name=f"{effect.name}.{each.name}")
            for effect in effects
            for each in effect.states
        )
        self.by_letter = {"p": self.p, "y": self.y, "dy": self.y, "c": self.c, "out": self.out}

    def steps(self) -> list[float]:
        """Absolute size of each state below which a difference step does not shrink."""
        return [slot.tolerance * 1e3 for slot in self.y.slots for _ in range(slot.size)]

    def sized(self, template: str) -> str:
        """Fill array sizes into an entry-point template."""
        return template.format(states=self.y.size, channels=self.c.size, outputs=self.out.size)

    def fill(self, source: str) -> str:
        """Return the source with hooks expanded and slots as subscripts."""
        lines: list[str] = []
        for line in source.splitlines():
            lines.append(line)
            if hook := _HOOK.match(line):
                lines += [hook[1] + call for call in self._calls(hook[2].split(", "))]
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
        arguments = ", ".join(self._argument(name, effect, axis) for name in term.arguments)
        call = f"{effect.name}_{plain(term.kernel).__name__}({arguments})"
        places = [f"c{self.c.text(name)}{index}" if axis else name for name in term.writes]
        rates = [f"dy{self.y.text(f'{effect.name}.{name}')}{index}" for name in term.states]
        if len(places) + len(rates) == 1:
            body = [f"{places[0]} += {call}"]
        else:
            added = [f"added_{n}" for n in range(len(places))]
            body = [f"{', '.join(added + rates)} = {call}"]
            body += [f"{place} += {value}" for place, value in zip(places, added, strict=True)]
        if not axis:
            return body
        return [f"for k in range({self.c.slot(target).size}):", *("    " + row for row in body)]

    def _argument(self, name: str, effect: Effect, axis: str) -> str:
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
        """Index of a slot's element in a loop over `axis`; joint kinds repeat MCP, PIP."""
        if not slot.axis or not axis:
            return ""
        if slot.axis == "kind":
            return "[k % 2]"
        same = {"phalanx": "joint"}
        if same.get(slot.axis, slot.axis) == same.get(axis, axis):
            return "[k]"
        if slot.axis == "finger":
            return "[k // 2]"
        return ""


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


def _without_outputs(text: str) -> str:
    """Drop the statements that only fill outputs, which the integrator does not need."""
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if isinstance(node, ast.Assign | ast.AugAssign) and _is_output(targets[0]):
            for number in range(node.lineno - 1, node.end_lineno or node.lineno):
                lines[number] = ""
    return "\n".join(lines) + "\n"


def _is_output(target: ast.AST | None) -> bool:
    while isinstance(target, ast.Subscript):
        target = target.value
    return isinstance(target, ast.Name) and target.id == "out"


def _fingerprint(function: Any) -> str:
    """Digest of all that enters a function's machine code, wherever it is written.

    These are its file and name, the constants it reads, and the same of every function that it
    reaches by its globals, by modules named there, or by its closure.
    """
    seen: set[Any] = set()
    parts: set[bytes] = set()

    def visit(each: Any) -> None:
        if each.__code__ in seen:
            return
        seen.add(each.__code__)
        source = inspect.getsourcefile(each)
        parts.add(f"{each.__module__}.{each.__qualname__}".encode())
        parts.add(Path(source).read_bytes() if source and Path(source).exists() else b"")
        for name, value in _reached(each):
            if hasattr(plain(value), "__code__"):
                visit(plain(value))
            elif isinstance(value, bool | int | float | complex | str | tuple):
                parts.add(f"{name} = {value!r}".encode())
            elif isinstance(value, np.ndarray):
                parts.add(name.encode() + str(value.dtype).encode() + value.tobytes())

    visit(plain(function))
    return hashlib.sha256(b"".join(sorted(parts))).hexdigest()


def _reached(function: Any) -> list[tuple[str, Any]]:
    """Name and value of whatever a function can look up."""
    names = function.__code__.co_names
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    found = list(zip(function.__code__.co_freevars, cells, strict=True))
    found += [(name, function.__globals__.get(name)) for name in names]
    modules = [value for _, value in found if isinstance(value, ModuleType)]
    return found + [(name, getattr(each, name, None)) for each in modules for name in names]


def _module(
    kind: str, text: str, names: dict[str, Any], origin: str, constants: dict[str, str]
) -> ModuleType:
    """Write the generated text once, under its digest, and load it with its kernels."""
    head = '"""Generated by hannes from its equations; edit those, not this."""\n\n'
    values = "\n".join(f"{name} = {value}" for name, value in constants.items())
    body = head + f"import numpy as np\n\n{values}\n\n\n" + _decorated(text)
    digest = hashlib.sha256((body + origin).encode()).hexdigest()[:16]
    path = cache_folder() / f"{kind}_{digest}.py"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, body)
    name = f"hannes_{kind}_{digest}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    functions = {key: value for key, value in names.items() if not key.startswith("__")}
    vars(module).update(functions, inner=inner, routine=routine, entry=entry)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _decorated(text: str) -> str:
    """Mark entry points, what stays a function of its own, and kernels."""
    for mark, names in (("entry", _OPEN), ("routine", _CLOSED)):
        text = re.sub(rf"^def ({names})\(", rf"@{mark}\ndef \1(", text, flags=re.MULTILINE)
    bare = r"^(?<!@entry\n)(?<!@routine\n)def "
    return re.sub(bare, "@inner\ndef ", text, flags=re.MULTILINE)
