"""Derivatives of tensions and border, as text made from their stages', effects included.

Straight-line text of what differs from zero: of tensions and of the rates of the border's states,
by these states, by the wire that each finger takes up and by its rate, and by time.
"""

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hannes.core.kernels.jit import plain
from hannes.core.kernels.smooth_switches import (
    limited,
    limited_slope,
    one_sided,
    one_sided_derivatives,
)
from hannes.core.layout import Layout
from hannes.dynamics.friction import stribeck, stribeck_slope
from hannes.simulation.compiler.autodiff.dead_code import without_dead_code
from hannes.simulation.compiler.autodiff.forward import Differentiation
from hannes.simulation.compiler.autodiff.values import Array, Value, Written

STAGES = """
def border(t, y, dy, p, c, reference, memory, out):
    target = position_reference(t, y, dy, p, c, reference, out)
    position, current = sense(t, y, dy, p, c, memory, out)
    duty = control(t, y, dy, p, c, memory, target, position, current, out)
    torque_constant = drive(t, y, dy, p, c, duty, out)
    load = leader(t, y, dy, p, c, out)
    gear(t, y, dy, p, c, torque_constant, load, out)
    carts(t, y, dy, p, c, out)
"""
WRITTEN = {
    plain(one_sided): Written(one_sided_derivatives, ("depth", "rate")),
    plain(stribeck): Written(stribeck_slope, ("speed",)),
    plain(limited): Written(limited_slope, ("x",)),
}
FINGERS = 5
TIME = "t"


@dataclass(frozen=True)
class Border:
    """The text of `border_columns`; by row, tensions first: by which border states, by whose wire.

    `timed`: tensions change with time by themselves.
    """

    text: str
    needed: list[list[bool]]
    couplings: list[list[bool]]
    timed: bool


def differentiated(
    source: str, names: Mapping[str, Any], channels: Layout, border: Sequence[int], timed: bool
) -> Border:
    """Differentiate the stages in `source`, whose border states lie at the places `border`.

    `timed`: df/dt is differenced as a whole. Raises NotDifferentiable where a stage cannot be
    differentiated.
    """
    count, tensions = len(border), channels["tendon_tension"].start
    found = _run(source, names, channels, border)
    places = [("c", tensions + f) for f in range(FINGERS)] + [("dy", place) for place in border]
    rows = [found.store[place].derivatives for place in places]
    timed = timed or any(TIME in row for row in rows[:FINGERS])
    lines = found.lines + [
        f"border[{column}, {i}] = {slope}"
        for i, row in enumerate(rows)
        for column, slope in row.items()
        if column != TIME
    ]
    rates = zip(border, rows[FINGERS:], strict=True)
    lines += [f"drift[{at}] = {row[TIME]}" for at, row in rates if TIME in row and not timed]
    lines += ["difference_time(t, y, rates, dy, drift, p, c, reference, memory, out)"] * timed
    head = [
        "def border_columns(t, y, rates, dy, drift, p, c, reference, memory, out, border):",
        '    """Fill `border` and `drift`, df/dt; see workspace in arrowhead.py."""',
        "    drift[:] = 0.0",
        "    excursions(y, p, c)",
    ]
    return Border(
        "\n".join([*head, *("    " + line for line in without_dead_code(lines))]) + "\n",
        [[j in row for j in range(count)] for row in rows],
        [[count + f in row or count + FINGERS + f in row for f in range(FINGERS)] for row in rows],
        timed,
    )


def _run(
    source: str, names: Mapping[str, Any], channels: Layout, border: Sequence[int]
) -> Differentiation:
    body = ast.parse(source + STAGES).body
    functions = {each.name: each for each in body if isinstance(each, ast.FunctionDef)}
    found = Differentiation(functions, names, WRITTEN)
    for column, place in enumerate(border):
        found.store["y", place] = Value(f"y[{place}]", {column: "1.0"})
    for kind, name in enumerate(("excursion", "excursion_rate")):
        for f in range(FINGERS):
            place, column = channels[name].start + f, len(border) + FINGERS * kind + f
            found.store["c", place] = Value(f"c[{place}]", {column: "1.0"})
    arrays = ("y", "dy", "p", "c", "reference", "memory", "out")
    found.run("border", [Value(TIME, {TIME: "1.0"}), *map(Array, arrays)])
    return found
