"""What the reproduction must show; every bound is an upper one."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from hannes.report.paper import published
from hannes.report.paper.runs import Runs, measured
from hannes.simulation.grasp_metrics import GraspMetrics, relative_error, void_current
from hannes.simulation.trajectory import Trajectory

Row = dict[str, Any]

WITHIN = 2.0  # % of each figure of Table II
CONTACT_WITHIN = 5.0  # % of 0.30 s
RTOL = 1e-4  # of the simulations on the page
TRACES = ("current", "position", "duty", "leader_tension", "joint_angle", "cart_position")


def must_show(runs: Runs) -> list[Row]:
    """Rows `name, value, bound, unit, holds` for everything that the page must show."""
    rigid, soft = measured(runs.rigid), measured(runs.soft)
    sweep = [measured(run) for run in runs.sweep.values()]
    return [
        *_table_2(rigid),
        _void(runs.unit),
        _same_before_touch(runs.rigid, runs.soft),
        *_ordered(rigid, soft),
        *_monotone(sweep),
    ]


def row(name: str, value: float, bound: float, unit: str = "", *, strict: bool = False) -> Row:
    """One figure: it holds where `value` is at most `bound` (below it where strict)."""
    holds = value < bound if strict else value <= bound
    return {"name": name, "value": value, "bound": bound, "unit": unit, "holds": bool(holds)}


def _table_2(ours: GraspMetrics) -> list[Row]:
    rows = [
        row(
            f"{each.symbol} off Table II's Hannes row",
            abs(relative_error(each.hand, getattr(ours, each.name))),
            WITHIN,
            "%",
        )
        for each in published.TABLE_2
    ]
    delay = abs(relative_error(published.CONTACT, ours.contact))
    return [*rows, row("first force above 1 N, off 0.30 s", delay, CONTACT_WITHIN, "%")]


def _void(unit: Trajectory) -> Row:
    off = abs(void_current(unit.time, unit["current"]) - published.VOID_CURRENT)
    return row("void current of the unit, off 0.25 A", off, published.VOID_SPREAD, "A")


def _same_before_touch(rigid: Trajectory, soft: Trajectory) -> Row:
    """Largest difference of all traces before either object is touched, over each one's peak."""
    touched = (rigid["force"] > 0.0) | (soft["force"] > 0.0)
    before = slice(0, int(np.argmax(touched)))
    if not before.stop:
        return row("rigid and soft traces apart before first touch", np.inf, 100.0 * RTOL, "%")
    apart = [
        np.abs(rigid[name][before] - soft[name][before]).max() / np.abs(rigid[name]).max()
        for name in TRACES
    ]
    return row(
        "rigid and soft traces apart before first touch", 100.0 * max(apart), 100.0 * RTOL, "%"
    )


def _ordered(rigid: GraspMetrics, soft: GraspMetrics) -> list[Row]:
    names = (("I_sc", "rising slope"), ("I_max", "peak current"), ("F_max", "peak force"))
    return [
        row(f"{text}, soft / rigid", getattr(soft, name) / getattr(rigid, name), 1.0, strict=True)
        for name, text in names
    ]


def _monotone(sweep: Sequence[GraspMetrics]) -> list[Row]:
    """The largest ratio of a softer to the next stiffer object over the sweep."""
    rows = []
    for name, text in (("I_sc", "slope"), ("I_max", "peak current"), ("F_max", "peak force")):
        values = [getattr(each, name) for each in sweep]
        worst = max(softer / stiffer for softer, stiffer in pairwise(values))
        rows.append(row(f"sweep: {text}, softer / next stiffer", worst, 1.0, strict=True))
    return rows
