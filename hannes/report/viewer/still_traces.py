"""Traces beside the picture of one moment, with a line at its time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hannes.report import style
from hannes.report.viewer.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

CHANNELS = ("position", "current", "leader_tension")
LOOKS = {
    "recorded": ({"color": style.BLACK}, {"color": style.GREY}),
    "simulated": ({"color": style.BLUE, "linestyle": "--"},
                  {"color": style.VERMILLION, "linestyle": ":"}),
}  # fmt: skip


def traces(figure: "Figure", place: "SubplotSpec", scenes: Sequence[Scene], time: float) -> None:
    """Position, current and leader tension over time, one panel each, all scenes over another."""
    names = [name for name in CHANNELS if any(_lines(scenes, name))]
    panels = place.subgridspec(max(1, len(names)), 1).subplots(sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=False):
        for label, x, values, look in _lines(scenes, name):
            axes.plot(x, values, linewidth=1.0, label=label, **look)
        unit = next(each.units[name] for each in scenes if name in each.units)
        axes.set_title(f"{name.replace('_', ' ')} [{unit}]", fontsize=7.5, loc="left", pad=2)
        axes.axvline(time, color=style.BLACK, linewidth=0.8, linestyle=":")
        axes.tick_params(labelsize=7)
    panels[-1].set_xlabel("time [s]", fontsize=7.5)
    found: dict[str, Any] = {}
    for axes in panels:
        found.update(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    words = sorted(found)
    panels[-1].legend(
        [found[each] for each in words], words, fontsize=6.5, loc="upper center",
        bbox_to_anchor=(0.4, -0.5),
    )  # fmt: skip


def _lines(scenes: Sequence[Scene], name: str) -> list[tuple[str, Any, Any, dict[str, Any]]]:
    """Label, times, values and look of every line of one channel."""
    found = []
    for k, each in enumerate(scenes):
        hand = f"simulated: {each.drawn_by or 'its own hand'}"
        words = {"recorded": each.name, "simulated": f"{each.name}, {hand}"}
        for kind, tables in (("recorded", each.recorded), ("simulated", each.simulated)):
            if name in tables:
                found.append((words[kind], each.time, tables[name], LOOKS[kind][min(k, 1)]))
    return found
