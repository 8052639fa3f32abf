"""Figs. 6 and 7: the hand closing on nothing."""

from typing import TYPE_CHECKING

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.formats import decimals, number
from hannes.report.paper import published
from hannes.simulation.grasp_metrics import closing_time, smoothed, void_current
from hannes.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WINDOW = (0.15, 0.30)  # s, over which metrics.void_current takes its mean
SHOWN = 0.45  # s of Fig. 7


def closure(run: Trajectory) -> Drawn:
    """Draw Fig. 6."""
    taken = closing_time(run.time, run["position"])
    return drawn(
        "fig6",
        "Fig. 6: free closure to the stops",
        f"The reference goes on until every finger is at its stop; the hand is closed (90 % of its "
        f"furthest position) after {decimals(taken, 3)} s. The paper publishes that its model's "
        "closing time is within 1 % of the hand's, but not the time itself.",
        f"Output angle over time: the position follows the rising reference closely until the "
        f"fingers meet their stops near {number(float(run['position'][-1]))} rad.",
        lambda: _draw_closure(run, taken),
    )


def _draw_closure(run: Trajectory, taken: float) -> "Figure":
    figure, (axes,) = style.panels(1, 2.6)
    reached = 0.9 * float(run["position"].max())
    axes.plot(run.time, run["reference"], label="reference", **style.THIRD)
    axes.plot(run.time, run["position"], label="ours", **style.FIRST)
    axes.plot([0.0, taken, taken], [reached, reached, 0.0], **style.MARK)
    axes.plot([taken], [reached], "o", color=style.BLUE, markerfacecolor="white")
    axes.annotate(
        f"closed: {decimals(taken, 3)} s",
        (taken, reached),
        xytext=(-8, 6),
        textcoords="offset points",
        ha="right",
    )
    axes.set(xlabel="time [s]", ylabel="output angle [rad]", xlim=(0.0, float(run.time[-1])))
    axes.set_ylim(bottom=0.0)
    style.legend(axes)
    return figure


def void(hands: list[Trajectory], unit: Trajectory) -> Drawn:
    """Draw Fig. 7."""
    levels = [void_current(each.time, each["current"]) for each in hands]
    return drawn(
        "fig7",
        "Fig. 7: void current of four virtual hands",
        f"The {len(hands)} thin lines are virtual hands: the unit's inexact values scattered at "
        "random, by a choice of spread. They are no recordings; the paper's four hands are not "
        "published. The band is the published 0.25 ± 0.03 A of those real hands, drawn over the "
        "window of our mean.",
        f"Current over the first {SHOWN} s of a free closure: a start peak, then a steady level. "
        f"Virtual hands lie between {number(min(levels))} and {number(max(levels))} A; the unit at "
        f"{number(void_current(unit.time, unit['current']))} A.",
        lambda: _draw_void(hands, unit),
    )


def _draw_void(hands: list[Trajectory], unit: Trajectory) -> "Figure":
    figure, (axes,) = style.panels(1, 2.9)
    low, high = (
        published.VOID_CURRENT - published.VOID_SPREAD,
        published.VOID_CURRENT + published.VOID_SPREAD,
    )
    axes.fill_between(WINDOW, low, high, color="#d0d0d0", label="published, hands")
    axes.plot(WINDOW, [published.VOID_CURRENT] * 2, label="published, mean", **style.PUBLISHED)
    axes.plot(WINDOW, [published.VOID_MODEL] * 2, label="published, model", **style.PUBLISHED_MODEL)
    sizes = np.array([smoothed(each["current"]) for each in hands])
    for k, size in enumerate(sizes):
        dashes = (0, (3 + k, 1.5))
        label = "virtual hands" if k == 0 else None
        axes.plot(unit.time, size, linestyle=dashes, label=label, **style.FAINT)
    axes.plot(unit.time, sizes.mean(axis=0), label="their mean", **style.FIRST)
    axes.plot(unit.time, smoothed(unit["current"]), label="our unit", **style.SECOND)
    axes.set(xlabel="time [s]", ylabel="motor current,\nmagnitude [A]", xlim=(0.0, SHOWN))
    axes.set_ylim(0.0, 0.45)
    style.legend(axes)
    return figure
