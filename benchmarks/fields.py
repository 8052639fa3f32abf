"""Stages of the equations over fields of records, beside subscripts expanded into their text.

The compiler expands `p.name`, `y.name`, `c.name` and `out.name` in the written equations to
subscripts of plain arrays. Here the same text is also compiled as it is written, over numba records
whose fields are these names, at the same places in memory; and once more with the sizes of loops
hidden from the compiler, as they are in the expanded text. The stages `joints` and `contact`, and
the rates of all states, along a dynamometer grasp of the hand without effects; all ways in turn in
one process, processor time a call. `over_expanded` is the median of the ratios of what ran in turn,
with its 95 % interval; all that the calls leave must be the same to the bit.
"""

import re
import sys
import time
import types
from collections.abc import Mapping
from typing import Any
from unittest.mock import patch

import numpy as np
from tqdm import tqdm

from benchmarks.batch import grasp
from benchmarks.harness import Row, interval, main, must_show
from hannes import Hand, simulate
from hannes.core.kernels.jit import inner, kernel, routine
from hannes.core.kernels.pointers import numbers_at, pointer, shaped, unknown
from hannes.core.layout import Layout
from hannes.simulation.compiler.autodiff.rules import LANES
from hannes.simulation.compiler.calling import SHAPES, by_address
from hannes.simulation.compiler.expansion import Layouts, without_outputs
from hannes.simulation.hand.model import EQUATIONS
from hannes.simulation.trajectory import Trajectory

WAYS = ("expanded", "fields", "fields, sizes unknown")
STAGES = ("joints", "contact", "equations")
ALONE = ("joints", "contact", "press", "inertia", "equations", "sample")  # as module_cache has them
FEASIBLE = 1.02  # times the expanded text's time: what fields may take
# A record is one word by itself, and only these arrays are left to hand on by their addresses.
_OF_RECORDS = {
    name: {each: SHAPES[name][each] for each in ("reference", "memory")}
    for name in ("equations", "sample")
}
ROUNDS = 20  # through all states in one turn


class _Fields(Layouts):
    """The same text, with its calls of effects, and names left as they are."""

    def _subscript(self, match: Any) -> str:
        return str(match[0])


def record(layout: Layout) -> np.dtype[Any]:
    """Type of a record with a field for each slot, at the slot's place in the plain array."""
    kinds: list[Any] = [("f8", (each.size,)) if each.axis else "f8" for each in layout.slots]
    names = [each.name for each in layout.slots]
    places = [8 * layout[name].start for name in names]
    given: Any = {"names": names, "formats": kinds, "offsets": places, "itemsize": 8 * layout.size}
    return np.dtype(given, align=True)


def _layouts(kind: type[Layouts]) -> Layouts:
    plant = EQUATIONS
    return kind(plant.parameters, plant.states, plant.channels, plant.outputs, ())


def texts() -> dict[str, str]:
    """The equations without what only fills outputs: expanded, and as they are written."""
    whole = _layouts(Layouts).expanded(EQUATIONS.source())
    expanded = without_outputs(whole).splitlines()
    written = _layouts(_Fields).expanded(EQUATIONS.source()).splitlines()
    pairs = zip(whole.splitlines(), expanded, written, strict=True)
    kept = [own if old == new else "" for old, new, own in pairs]
    fields = _less_zeroing(kept)
    unknown_sizes = re.sub(r"\b[pc]\.\w+\.size\b", r"unknown(\g<0>)", fields)
    return dict(zip(WAYS, (_less_zeroing(expanded), fields, unknown_sizes), strict=True))


def _less_zeroing(lines: list[str]) -> str:
    """The text without the loop that sets all rates to zero, which a record does not have."""
    return re.sub(r"    for i in range\(dy\.size\):\n.*\n", "", "\n".join(lines) + "\n")


def compiled(text: str, way: str) -> types.ModuleType:
    """The functions of a text, marked as the compiler marks them; nothing is kept on disk."""
    layouts = _layouts(Layouts)
    text = re.sub(rf"^def ({'|'.join(ALONE)})\(", r"@routine\ndef \1(", text, flags=re.MULTILINE)
    text = re.sub(r"^(?<!@routine\n)def ", "@inner\ndef ", text, flags=re.MULTILINE)
    words = SHAPES if way == "expanded" else _OF_RECORDS
    with patch.dict(SHAPES, dict(words), clear=True):
        text = by_address(text)
    made = types.ModuleType("expanded_or_fields")
    vars(made).update(vars(EQUATIONS.module) | LANES)
    vars(made).update({name: int(size) for name, size in layouts.sizes().items() if size.isdigit()})
    vars(made).update(
        routine=routine, inner=inner, pointer=pointer, shaped=shaped, unknown=unknown,
        numbers_at=numbers_at,
    )  # fmt: skip
    exec(compile(text, f"<{way}>", "exec"), vars(made))
    return made


def loops(functions: types.ModuleType) -> dict[str, Any]:
    """By stage, a compiled loop over all states that calls it."""
    joints, contact, equations = (getattr(functions, name) for name in STAGES)

    @kernel
    def run_joints(rounds, times, y, dy, p, c, out, reference, memory):
        for _ in range(rounds):
            for k in range(times.size):
                joints(times[k], y[k], dy[k], p[0], c[k], out[0])

    @kernel
    def run_contact(rounds, times, y, dy, p, c, out, reference, memory):
        for _ in range(rounds):
            for k in range(times.size):
                contact(times[k], y[k], dy[k], p[0], c[k], out[0])

    @kernel
    def run_equations(rounds, times, y, dy, p, c, out, reference, memory):
        for _ in range(rounds):
            for k in range(times.size):
                equations(times[k], y[k], dy[k], p[0], c[k], reference, memory, out[0])

    return dict(zip(STAGES, (run_joints, run_contact, run_equations), strict=True))


def _arrays(ran: Trajectory) -> list[np.ndarray]:
    """States, their rates, parameters, channels and outputs: a row for each state, or one."""
    states, plant = ran.states[::10].copy(), EQUATIONS
    channels, outputs = np.zeros((states.shape[0], plant.channels.size)), plant.outputs.size
    return [
        states, np.zeros_like(states), ran.parameters[np.newaxis], channels, np.zeros((1, outputs))
    ]  # fmt: skip


def _records(arrays: list[np.ndarray]) -> list[np.ndarray]:
    """The same memory as records, one a row."""
    plant = EQUATIONS
    layouts = plant.states, plant.states, plant.parameters, plant.channels, plant.outputs
    return [each.view(record(layout))[:, 0] for each, layout in zip(arrays, layouts, strict=True)]


def results(ran: Trajectory, runs: Mapping[str, dict[str, Any]]) -> dict[str, bytes]:
    """By way, the rates and channels that all stages leave one after the other."""
    found = {}
    for way, stages in runs.items():
        given = ways(ran)[way]
        for stage in reversed(STAGES):
            stages[stage](1, *given)
        found[way] = given[2].tobytes() + given[4].tobytes()
    return found


def ways(ran: Trajectory) -> dict[str, tuple[Any, ...]]:
    """By way, what the loops are given: the same memory, whose place is luck, for all."""
    arrays, times = _arrays(ran), ran.time[::10].copy()
    further = ran.knots, ran.memories[0].copy()
    whole = {"expanded": (times, *arrays, *further)}
    return whole | dict.fromkeys(WAYS[1:], (times, *_records(arrays), *further))


def timed(
    runs: Mapping[str, Any], given: Mapping[str, tuple[Any, ...]], repeats: int
) -> dict[str, np.ndarray]:
    """By way, the nanoseconds of a call in each turn, forwards and backwards."""
    took: dict[str, list[float]] = {way: [] for way in runs}
    for repeat in tqdm(range(repeats), "turns", leave=False):
        for way in list(runs)[:: 1 if repeat % 2 else -1]:
            begun = time.process_time()
            runs[way](ROUNDS, *given[way])
            took[way].append(time.process_time() - begun)
    calls = ROUNDS * given["expanded"][0].size
    return {way: 1e9 * np.array(each) / calls for way, each in took.items()}


def measure(quick: bool) -> tuple[list[Row], list[Row]]:
    """A row for each stage."""
    ran = simulate(Hand(), grasp(), rtol=1e-3).require()
    runs = {}
    for way, text in texts().items():
        print(f"fields: compiling, {way}", file=sys.stderr, flush=True)
        runs[way] = loops(compiled(text, way))
    same = len(set(results(ran, runs).values())) == 1
    rows, bounds, given = list[Row](), list[Row](), ways(ran)
    for stage in reversed(STAGES):  # the rates of all states fill the channels of the others
        took = timed({way: runs[way][stage] for way in WAYS}, given, 20 if quick else 200)
        for way in WAYS:
            over = took[way] / took["expanded"]
            ratio = {"over_expanded": float(np.median(over)), **interval(over.tolist())}
            rows.append({"stage": stage, "way": way, "ns": float(np.median(took[way])), **ratio})
            held = ratio["high"] < FEASIBLE
            what = f"{stage}, {way}, over expanded text"
            if way != "expanded":
                bounds.append(must_show(what, ratio["over_expanded"], FEASIBLE, held) | ratio)
    for bound in bounds:
        del bound["over_expanded"]
    return rows, [*bounds, must_show("results that differ in a bit", int(not same), 0, same)]


if __name__ == "__main__":
    main(__doc__, "fields", measure)
