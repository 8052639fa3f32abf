"""Figures of a calibration: intervals side by side, then traces before and after."""

from typing import TYPE_CHECKING

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.figure_diagnosis import MEASURED, NOMINAL, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hannes.identification.calibration.result import Fit

WIDE = 30.0  # %, at which the bar of an interval is cut


def figures(result: "Fit") -> list[Drawn]:
    """Intervals, then one figure for each channel of the first recording shown."""
    return [_intervals(result), *_traces(result)]


def _intervals(result: "Fit") -> Drawn:
    rows = [each for each in result.answers if each.value != 0.0][::-1]
    names = [each.name for each in rows]

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 0.7 + 0.26 * len(rows))
        for place, each in enumerate(rows):
            colour = style.BLUE if each.identified else style.GREY
            _bar(axes, place + 0.12, _cut(each.value, each.low, each.high), colour, 3.0)
            _bar(axes, place - 0.2, _cut(each.value, *each.textbook), style.ORANGE, 1.6)
        axes.set_yticks(range(len(rows)), names)
        axes.axvline(0.0, **style.MARK)
        axes.set_xlabel("distance from the fitted value [%]")
        axes.grid(axis="y", visible=False)
        return figure

    alt = "; ".join(
        f"{each.name} {_relative(each.value, each.low, each.high)[0]:.2g} to "
        f"{_relative(each.value, each.low, each.high)[1]:+.2g} % ({each.label})"
        for each in rows[::-1]
    )
    caption = (
        "95 % intervals by run: blue where identified, grey where not (cut at "
        f"±{WIDE:g} %). Thin orange: what the textbook covariance claims."
    )
    return drawn("calibration-intervals", "How well each is known", caption, alt, draw)


def _relative(value: float, low: float, high: float) -> tuple[float, float]:
    """Ends of an interval relative to its value [%]."""
    return 100.0 * (low - value) / abs(value), 100.0 * (high - value) / abs(value)


def _cut(value: float, low: float, high: float) -> tuple[float, float]:
    """The same as far as they are drawn."""
    low, high = _relative(value, low, high)
    return max(low, -WIDE), min(high, WIDE)


def _bar(axes: "Axes", height: float, ends: tuple[float, float], colour: str, width: float) -> None:
    axes.plot(ends, (height, height), color=colour, linewidth=width, solid_capstyle="butt")


def _traces(result: "Fit") -> list[Drawn]:
    entry = (result.campaign.of("show") or result.campaign.of("fit", "select"))[0]
    recording, plant = entry.recording, result.campaign.plant
    before, after = plant.simulate({}, recording), result.plant.simulate({}, recording)
    mask = plant.judged_part(recording)
    about = f"Recording {entry.name} ({entry.condition}), role {entry.role}."

    def one(name: str) -> Drawn:
        unit, gap = plant.channels[name], (result.gap or result.fitted_gap).get(name)
        label = f"{name} [{unit}]" if unit != "1" else name
        alt = f"{name} over time, measured, as given and calibrated."
        if gap:
            alt += f" RMS gap as given {gap['as_given']:.3g}, after {gap['after']:.3g} {unit}."

        def draw() -> "Figure":
            figure, (above, below) = style.panels(2)
            for text, values, look in (
                ("measured", recording[name], MEASURED),
                ("as given", before[name], NOMINAL),
                ("calibrated", after[name], style.FIRST),
            ):
                above.plot(*thinned(recording.time, values), label=text, **{**look, "zorder": 2})
            above.set_ylabel(label)
            style.legend(above, ncols=3)
            difference = np.where(mask, after[name] - recording[name], np.nan)
            below.plot(*thinned(recording.time, difference), **{**style.FIRST, "linewidth": 1.1})
            if gap and np.isfinite(gap["floor"]):
                below.axhspan(-gap["floor"], gap["floor"], color=style.GREY, alpha=0.25)
            below.set_ylabel("residual" if unit == "1" else f"residual [{unit}]")
            below.set_xlabel("time [s]")
            return figure

        caption = f"{about} Below: simulated minus measured; grey: {result.floor_from}."
        return drawn(f"calibration-{name}", f"{name.capitalize()}", caption, alt, draw)

    return [one(name) for name in result.found.plan.channels if name in recording]
