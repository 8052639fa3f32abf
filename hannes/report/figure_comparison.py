"""Figs. 6, 7 and 8 of the paper for recordings: measured beside simulated."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.figure_diagnosis import thinned
from hannes.report.formats import number, signed
from hannes.simulation.grasp_metrics import smoothed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hannes.identification.comparison.aligned_run import AlignedRun
    from hannes.identification.comparison.comparison import Condition

MOST = 12  # recordings that are drawn one by one
MAGNITUDE = "motor current,\nmagnitude [A]"
BAND: dict[str, Any] = {"color": style.BLUE, "alpha": 0.18, "linewidth": 0.0}
SHADOW: dict[str, Any] = {"color": style.SKY, "linewidth": 0.9, "linestyle": (0, (3, 1.5))}
VOID_SHOWN = 0.45  # s, as in Fig. 7
MEAN, MODEL = "measured, mean", "simulated"


def figures(condition: "Condition", place: int) -> list[Drawn]:
    """Figs. 6 and 7 of a free closure, Fig. 8 of a grasp; only of what was recorded."""
    runs = [each.run for each in condition.runs]
    if runs[0].stiffness:
        return [_grasp(condition, runs, place)] if _all_have(runs, "current") else []
    made = []
    if _all_have(runs, "position"):
        made.append(_closure(condition, runs, place))
    if _all_have(runs, "current"):
        made.append(_void(condition, runs, place))
    return made


def _all_have(runs: Sequence["AlignedRun"], name: str) -> bool:
    return all(name in run.measured for run in runs)


def _closure(condition: "Condition", runs: list["AlignedRun"], place: int) -> Drawn:
    found = _said(condition, "closing time")

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 2.6)
        axes.plot(*thinned(runs[0].time, runs[0].reference), label="reference", **style.THIRD)
        time = _both(axes, runs, "position", np.asarray)
        for row in condition.rows:
            if row.metric == "closing time":
                axes.axvline(row.measured.mean, **{**style.MARK, "color": style.BLUE})
                axes.axvline(row.simulated.mean, **{**style.MARK, "color": style.VERMILLION})
        axes.set(xlabel="time [s]", ylabel="output angle [rad]", xlim=(0.0, float(time[-1])))
        style.legend(axes)
        return figure

    caption = f"{condition.name}. {found} Dotted: closing times."
    alt = f"Output angle over time, measured and simulated. {found}"
    return drawn(f"fig6-{place}", "Fig. 6: free closure", caption, alt, draw)


def _void(condition: "Condition", runs: list["AlignedRun"], place: int) -> Drawn:
    found = _said(condition, "void current")

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 2.6)
        time = _both(axes, runs, "current", smoothed)
        axes.set(xlabel="time [s]", ylabel=MAGNITUDE, xlim=(0.0, min(VOID_SHOWN, float(time[-1]))))
        axes.set_ylim(bottom=0.0)
        style.legend(axes)
        return figure

    caption = f"{condition.name}. {found} {_band_said(runs)}"
    alt = f"Magnitude of the motor current over time, measured and simulated. {found}"
    return drawn(f"fig7-{place}", "Fig. 7: void current", caption, alt, draw)


def _grasp(condition: "Condition", runs: list["AlignedRun"], place: int) -> Drawn:
    touch = runs[0].touch if _all_have(runs, runs[0].touch) else ""
    found = _said(condition, "I_max", "F_max")

    def draw() -> "Figure":
        figure, panels = style.panels(2 if touch else 1, 2.4)
        time = _both(panels[0], runs, "current", smoothed)
        panels[0].set(ylabel=MAGNITUDE, xlim=(0.0, float(time[-1])))
        if touch:
            _both(panels[1], runs, touch, np.asarray)
            label = "grasp force [N]" if touch == "force" else "dynamometer [N]"
            panels[1].set(ylabel=label)
        for axes in panels:
            axes.set_ylim(bottom=0.0)
            for row in condition.rows:
                if row.metric == "contact":
                    axes.axvline(row.measured.mean, **{**style.MARK, "color": style.BLUE})
                    axes.axvline(row.simulated.mean, **{**style.MARK, "color": style.VERMILLION})
        panels[-1].set_xlabel("time [s]")
        style.legend(panels[0])
        return figure

    caption = f"{condition.name}. {found} Dotted: first contact. {_band_said(runs)}"
    what = "Motor current and force" if touch else "Motor current"
    alt = f"{what} over time, measured and simulated. {found}"
    return drawn(f"fig8-{place}", "Fig. 8: grasp", caption, alt, draw)


def _said(condition: "Condition", *names: str) -> str:
    """What was measured and simulated, in words."""
    texts = []
    for row in condition.rows:
        if row.metric in names:
            spread = row.measured.units if row.measured.units is not None else row.measured.repeats
            about = "" if spread is None else f" ± {number(spread, 2)}"
            texts.append(
                f"{row.metric}: measured {number(row.measured.mean)}{about} {row.unit}, simulated "
                f"{number(row.simulated.mean)} {row.unit}, error {signed(row.error)} %."
            )
    return " ".join(texts)


def _band_said(runs: Sequence["AlignedRun"]) -> str:
    lines = _lines(runs)
    if len(lines) < 2:
        return "One recording: nothing is known of how far runs differ."
    what = "units" if len({run.unit for run in runs}) > 1 else "recordings"
    return f"Thin: {len(lines)} {what}. Band: their mean ± standard deviation."


def _lines(runs: Sequence["AlignedRun"]) -> list[list["AlignedRun"]]:
    """What is one thin line: a unit's recordings where there are several units, else each one."""
    units = dict.fromkeys(run.unit for run in runs)
    if len(units) == 1:
        return [[run] for run in runs]
    return [[run for run in runs if run.unit == unit] for unit in units]


def _both(
    axes: "Axes",
    runs: Sequence["AlignedRun"],
    name: str,
    transform: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Draw a channel of all runs: each line, their mean and band, the simulation; return times."""
    time = min((run.time for run in runs), key=len)

    def mean(group: Sequence["AlignedRun"], simulated: bool) -> np.ndarray:
        sides = (run.simulated if simulated else run.measured for run in group)
        return np.mean([transform(side[name])[: time.size] for side in sides], axis=0)

    lines = np.array([mean(group, simulated=False) for group in _lines(runs)])
    middle = lines.mean(axis=0)
    if len(lines) > 1:
        away = lines.std(axis=0, ddof=1)
        kept = slice(None, None, max(1, time.size // 900))
        axes.fill_between(time[kept], (middle - away)[kept], (middle + away)[kept], **BAND)
        for line in lines[:MOST]:
            axes.plot(*thinned(time, line), **SHADOW)
    label = MEAN if len(lines) > 1 else "measured"
    axes.plot(*thinned(time, middle), label=label, **style.FIRST)
    groups = [mean(group, simulated=True) for group in _lines(runs)]
    axes.plot(*thinned(time, np.mean(groups, axis=0)), label=MODEL, **style.SECOND)
    return time
