"""Figs. 3 and 8: currents and forces of a grasp."""

from typing import TYPE_CHECKING

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.formats import number
from hannes.report.paper import published
from hannes.report.paper.runs import measured
from hannes.simulation.grasp_metrics import GraspMetrics, smoothed
from hannes.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAGNITUDE = "motor current,\nmagnitude [A]"
FORCE = "grasp force [N]"
PUBLISHED = {each.name: each for each in published.TABLE_2}


def rigid_and_soft(rigid: Trajectory, soft: Trajectory) -> Drawn:
    """Draw Fig. 3."""
    one, other = measured(rigid), measured(soft)
    return drawn(
        "fig3",
        "Fig. 3: rigid and soft object",
        f"The same command on the dynamometer ({_stiffness(rigid)} N/m) and on a soft ball "
        f"({_stiffness(soft)} N/m). Dotted: the ends of void closing, grasp and void opening as "
        "the paper gives them. Stiffness, size and place of both objects are choices.",
        f"Two panels over time. Current: both lines coincide until first touch at "
        f"{number(min(one.contact, other.contact))} s; then the rigid one rises to "
        f"{number(one.I_max)} A, the soft one to {number(other.I_max)} A. Force: "
        f"{number(one.F_max)} N rigid, {number(other.F_max)} N soft.",
        lambda: _draw_pair(rigid, soft),
    )


def _stiffness(run: Trajectory) -> str:
    return f"{run.parameters[run.compiled.parameters['object_stiffness']][0]:g}"


def _draw_pair(rigid: Trajectory, soft: Trajectory) -> "Figure":
    figure, (current, force) = style.panels(2)
    for run, label, line in ((rigid, "rigid", style.FIRST), (soft, "soft", style.SECOND)):
        current.plot(run.time, smoothed(run["current"]), label=label, **line)
        force.plot(run.time, run["force"], label=label, **line)
    for axes in (current, force):
        for end in published.PHASES:
            axes.axvline(end, **style.MARK)
        axes.set_ylim(bottom=0.0)
    _name_phases(current)
    _frame(current, force, rigid)
    return figure


def _name_phases(axes: "Axes") -> None:
    starts = (0.0, *published.PHASES[:-1])
    for start, end, name in zip(
        starts, published.PHASES, ("closing", "grasp", "opening"), strict=True
    ):
        axes.text(
            (start + end) / 2.0,
            0.98,
            name,
            transform=axes.get_xaxis_transform(),
            ha="center",
            va="top",
            color=style.GREY,
            fontsize=8.0,
        )


def _frame(current: "Axes", force: "Axes", run: Trajectory) -> None:
    current.set(ylabel=MAGNITUDE, xlim=(0.0, float(run.time[-1])))
    force.set(ylabel=FORCE, xlabel="time [s]")
    style.legend(current)


def dynamometer(run: Trajectory) -> Drawn:
    """Draw Fig. 8."""
    ours = measured(run)
    return drawn(
        "fig8",
        "Fig. 8: grasping the dynamometer",
        "Ours as a line. Everything black or grey is a published number, not a measured curve: "
        "mean and peak levels of Table II, its slopes as short segments laid where ours are, and "
        "peak forces.",
        f"Two panels over time. Our current stays near {number(ours.I_avgc)} A while closing, "
        f"rises from {number(ours.contact)} s to a peak of {number(ours.I_max)} A, falls, and is "
        f"near {number(ours.I_avgo)} A while opening. Our force peaks at {number(ours.F_max)} N; "
        "published levels of 194.8 N (hand) and 174.9 N (the paper's model) are drawn as lines.",
        lambda: _draw_dynamometer(run, ours),
    )


def _draw_dynamometer(run: Trajectory, ours: GraspMetrics) -> "Figure":
    figure, (current, force) = style.panels(2, 2.5)
    size = smoothed(run["current"])
    current.plot(run.time, size, label="ours", **style.FIRST)
    force.plot(run.time, run["force"], **style.FIRST)
    peak = float(run.time[np.argmax(size)])
    spans = {
        "I_avgc": (0.02, ours.contact),
        "I_max": (peak - 0.13, peak + 0.13),
        "I_avgo": (ours.release, min(ours.release + 0.13, float(run.time[-1]))),
    }
    for name, span in spans.items():
        _level(current, span, PUBLISHED[name].hand, PUBLISHED[name].model)
    _slopes(current, run.time, size, int(np.argmax(size)))
    at = float(run.time[np.argmax(run["force"])])
    _level(force, (at - 0.13, at + 0.13), PUBLISHED["F_max"].hand, PUBLISHED["F_max"].model)
    for axes, top in ((current, 2.9), (force, 220.0)):
        axes.axvline(published.CONTACT, **style.MARK)
        axes.set_ylim(0.0, max(top, axes.get_ylim()[1]))
    current.text(published.CONTACT - 0.01, 1.5, "contact,\npublished", ha="right", color=style.GREY)
    _frame(current, force, run)
    return figure


def _level(axes: "Axes", span: tuple[float, float], hand: float, model: float) -> None:
    labelled = axes.get_legend_handles_labels()[1]
    place = axes.get_subplotspec()
    top = place is not None and place.rowspan.start == 0
    named = top and "published, hand" not in labelled
    hands, models = ("published, hand", "published, model") if named else ("", "")
    axes.plot(span, (model, model), label=models or None, zorder=4, **style.PUBLISHED_MODEL)
    axes.plot(span, (hand, hand), label=hands or None, zorder=5, **style.PUBLISHED)


def _slopes(axes: "Axes", time: np.ndarray, size: np.ndarray, peak: int) -> None:
    half = 0.5 * size[peak]
    rise = int(np.flatnonzero(size[:peak] < half)[-1])
    fall = peak + int(np.flatnonzero(size[peak:] < half)[0])
    for name, place in (("I_sc", rise), ("I_so", fall)):
        for slope, line in (
            (PUBLISHED[name].model, style.PUBLISHED_MODEL),
            (PUBLISHED[name].hand, style.PUBLISHED),
        ):
            reach = 0.55 / abs(slope)
            ends = np.array([-reach, reach])
            axes.plot(time[place] + ends, half + slope * ends, zorder=5, **line)
