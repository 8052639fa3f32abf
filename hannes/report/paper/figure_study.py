"""What stiffness does to a grasp, and what sampling the controller does."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.formats import number, power
from hannes.report.paper.runs import measured
from hannes.simulation.grasp_metrics import smoothed
from hannes.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SWEPT = (
    ("I_sc", "rising slope\n[A/s]"),
    ("I_max", "peak current\n[A]"),
    ("F_max", "peak force\n[N]"),
)


def stiffness(sweep: Mapping[float, Trajectory]) -> Drawn:
    """Draw rising slope, peak current and peak force against the object's stiffness."""
    metrics = [measured(run) for run in sweep.values()]
    low, high = min(sweep), max(sweep)
    return drawn(
        "stiffness",
        "Stiffness sweep",
        "One shape, one command, only the contact stiffness differs. The paper reports a "
        '"proportionality" of slope and peak of the current with stiffness; here both rise with '
        "stiffness and level off. A stiffer object can be distinguished from a softer one, but no "
        "straight line through zero holds over the range.",
        f"Three panels against stiffness from {low:g} to {high:g} N/m, logarithmic axis. Slope, "
        f"peak current and peak force go from {number(metrics[0].I_sc)} A/s, "
        f"{number(metrics[0].I_max)} A and {number(metrics[0].F_max)} N to "
        f"{number(metrics[-1].I_sc)} A/s, {number(metrics[-1].I_max)} A, "
        f"{number(metrics[-1].F_max)} N.",
        lambda: _draw_sweep(np.array(list(sweep)), metrics),
    )


def _draw_sweep(stiffnesses: np.ndarray, metrics: list) -> "Figure":
    figure, panels = style.panels(3, 1.5)
    for axes, (name, label) in zip(panels, SWEPT, strict=True):
        values = [getattr(each, name) for each in metrics]
        axes.plot(stiffnesses, values, marker="o", markersize=4.5, **style.FIRST)
        axes.set(ylabel=label, xscale="log")
        axes.set_ylim(bottom=0.0)
    panels[-1].xaxis.set_major_formatter(lambda value, _: power(value))
    panels[-1].set_xlabel("contact stiffness at each phalanx [N/m]")
    figure.align_ylabels(panels)
    return figure


def controllers(continuous: Trajectory, sampled: Trajectory) -> Drawn:
    """Draw one grasp under the continuous and under the sampled controller."""
    apart = smoothed(sampled["current"]) - smoothed(continuous["current"])
    worst = float(np.abs(apart).max())
    return drawn(
        "controllers",
        "One grasp, two controllers",
        "Continuous, as every other figure, and sampled with a quantised encoder and the duty held "
        f"between ticks, as firmware does. Their currents differ by at most {number(worst, 2)} A "
        "after the 11 ms mean.",
        "Three panels over time: current and force under both controllers nearly coincide; the "
        f"difference of the currents stays within {number(worst, 2)} A.",
        lambda: _draw_controllers(continuous, sampled, apart),
    )


def _draw_controllers(continuous: Trajectory, sampled: Trajectory, apart: np.ndarray) -> "Figure":
    figure, (current, force, difference) = style.panels(3, 1.6)
    for run, label, line in (
        (continuous, "continuous", style.FIRST),
        (sampled, "sampled", style.SECOND),
    ):
        current.plot(run.time, smoothed(run["current"]), label=label, **line)
        force.plot(run.time, run["force"], **line)
    difference.plot(continuous.time, apart * 1e3, color=style.BLACK, linewidth=1.0)
    difference.axhline(0.0, **style.MARK)
    current.set(ylabel="current,\nmagnitude [A]", xlim=(0.0, float(continuous.time[-1])))
    force.set(ylabel="grasp\nforce [N]")
    difference.set(ylabel="sampled minus\ncontinuous [mA]", xlabel="time [s]")
    style.legend(current)
    figure.align_ylabels([current, force, difference])
    return figure
