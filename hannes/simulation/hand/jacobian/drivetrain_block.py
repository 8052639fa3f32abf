"""Derivatives of tensions and core, as text derived from that of their stages, effects included.

Straight-line text of what differs from zero: of tensions and of the rates of the core's states, by
these states, by the wire that each finger takes up and by its rate, and by time.
"""

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hannes.core.kernels.jit import plain
from hannes.core.kernels.smooth_switches import limited, limited_slope, one_sided, one_sided_slopes
from hannes.core.layout import Layout
from hannes.dynamics.friction import stribeck, stribeck_slope
from hannes.simulation.compiler.autodiff.dead_code import alive
from hannes.simulation.compiler.autodiff.forward import Derivation
from hannes.simulation.compiler.autodiff.values import Array, Value, Written

STAGES = """
def core(t, y, dy, p, c, reference, hold, out):
    target = position_reference(t, y, dy, p, c, reference, out)
    position, current = sense(t, y, dy, p, c, hold, out)
    duty = control(t, y, dy, p, c, hold, target, position, current, out)
    torque_constant = drive(t, y, dy, p, c, duty, out)
    load = leader(t, y, dy, p, c, out)
    gear(t, y, dy, p, c, torque_constant, load, out)
    carts(t, y, dy, p, c, out)
"""
WRITTEN = {
    plain(one_sided): Written(one_sided_slopes, ("depth", "rate")),
    plain(stribeck): Written(stribeck_slope, ("speed",)),
    plain(limited): Written(limited_slope, ("x",)),
}
FINGERS = 5
TIME = "t"


@dataclass(frozen=True)
class Core:
    """The text of `core_columns`; by row, tensions first: by which core states, by whose wire.

    `timed`: tensions change with time by themselves.
    """

    text: str
    needed: list[list[bool]]
    takes: list[list[bool]]
    timed: bool


def derived(
    source: str, names: Mapping[str, Any], channels: Layout, core: Sequence[int], timed: bool
) -> Core:
    """Derive the stages in `source`, whose core states lie at the places `core`.

    `timed`: df/dt is differenced as a whole. Raises Underivable where a stage cannot be derived.
    """
    count, tensions = len(core), channels["tendon_tension"].start
    found = _run(source, names, channels, core)
    places = [("c", tensions + f) for f in range(FINGERS)] + [("dy", place) for place in core]
    rows = [found.cells[place].slopes for place in places]
    timed = timed or any(TIME in row for row in rows[:FINGERS])
    lines = found.lines + [
        f"core[{column}, {i}] = {slope}"
        for i, row in enumerate(rows)
        for column, slope in row.items()
        if column != TIME
    ]
    rates = zip(core, rows[FINGERS:], strict=True)
    lines += [f"drift[{at}] = {row[TIME]}" for at, row in rates if TIME in row and not timed]
    lines += ["difference_time(t, y, rates, dy, drift, p, c, reference, hold, out)"] * timed
    head = [
        "def core_columns(t, y, rates, dy, drift, p, c, reference, hold, out, core):",
        '    """Fill `core` and `drift`, df/dt; see workspace in arrowhead.py."""',
        "    drift[:] = 0.0",
        "    excursions(y, p, c)",
    ]
    return Core(
        "\n".join([*head, *("    " + line for line in alive(lines))]) + "\n",
        [[j in row for j in range(count)] for row in rows],
        [[count + f in row or count + FINGERS + f in row for f in range(FINGERS)] for row in rows],
        timed,
    )


def _run(
    source: str, names: Mapping[str, Any], channels: Layout, core: Sequence[int]
) -> Derivation:
    body = ast.parse(source + STAGES).body
    functions = {each.name: each for each in body if isinstance(each, ast.FunctionDef)}
    found = Derivation(functions, names, WRITTEN)
    for column, place in enumerate(core):
        found.cells["y", place] = Value(f"y[{place}]", {column: "1.0"})
    for kind, name in enumerate(("excursion", "excursion_rate")):
        for f in range(FINGERS):
            place, column = channels[name].start + f, len(core) + FINGERS * kind + f
            found.cells["c", place] = Value(f"c[{place}]", {column: "1.0"})
    arrays = ("y", "dy", "p", "c", "reference", "hold", "out")
    found.run("core", [Value(TIME, {TIME: "1.0"}), *map(Array, arrays)])
    return found
