"""Figures of an evaluation: scores by object, and how far probabilities mean what they say."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hannes.report import style
from hannes.report.figure import Drawn, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figures(evaluation: Mapping[str, Any]) -> list[Drawn]:
    """Scores by object, then predicted probabilities beside frequencies."""
    return [_scores(evaluation), _reliability(evaluation)]


def _scores(evaluation: Mapping[str, Any]) -> Drawn:
    rows = sorted(evaluation["objects"], key=lambda each: each["f1_windows"])

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 0.7 + 0.26 * len(rows))
        colours = [style.VERMILLION if each["class"] == "soft" else style.BLUE for each in rows]
        axes.barh(range(len(rows)), [100.0 * each["f1_windows"] for each in rows], color=colours)
        axes.set_yticks(range(len(rows)), [f"{each['name']} ({each['class']})" for each in rows])
        axes.set(xlabel="F1 of windows [%]", xlim=(0.0, 100.0))
        axes.grid(axis="y", visible=False)
        return figure

    alt = "; ".join(f"{each['name']} {100.0 * each['f1_windows']:.1f} %" for each in rows[::-1])
    caption = "By object, the least at the bottom. Blue: rigid; orange: soft."
    return drawn("evaluation-objects", "How well each object is recognised", caption, alt, draw)


def _reliability(evaluation: Mapping[str, Any]) -> Drawn:
    found = evaluation["reliability"]
    predicted = [each["predicted"] for each in found["rows"]]
    rigid = [each["rigid"] for each in found["rows"]]

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 2.6)
        axes.plot((0.0, 1.0), (0.0, 1.0), label="as it should be", **style.THIRD)
        axes.plot(predicted, rigid, label="windows, by tenths", **{**style.FIRST, "marker": "o"})
        axes.set(xlabel="predicted probability of rigid", ylabel="share that is rigid")
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
        style.legend(axes)
        return figure

    off = f"{100.0 * found['calibration_error']:.1f} points off on average."
    alt = f"Predicted probability of rigid beside its frequency. {off}"
    return drawn("evaluation-reliability", "Do probabilities mean what they say", off, alt, draw)
