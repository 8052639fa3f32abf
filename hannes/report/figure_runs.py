"""The figure of an experiment's results: channels over time, one line a variant."""

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING, Any

from hannes.core.recording.recording import Recording
from hannes.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANELS = {"position": "position", "current": "current", "duty": "duty", "force": "grip force"}
COLOURS = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE, style.SKY)
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (4, 1.5, 1, 1.5)), (0, (2, 1)))


def runs_svg(title: str, recordings: Mapping[str, Recording]) -> str:
    """Return an SVG of position, current, duty and grip force of each variant by its name."""
    first = next(iter(recordings.values()))
    moved = [name for name in PANELS if any(each[name].any() for each in recordings.values())]
    shown = moved or ["position"]
    with style.styled():
        figure, axes = style.panels(len(shown), 1.6)
        for panel, name in zip(axes, shown, strict=True):
            panel.set_ylabel(f"{PANELS[name]} [{first.units[name]}]".replace(" [1]", ""))
            if name == "position":
                panel.plot(first.time, first["reference"], **style.MARK, label="reference")
            _plot(panel, name, recordings)
        axes[-1].set_xlabel("time [s]")
        figure.suptitle(title, x=0.02, ha="left", fontsize=10)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower left", ncols=3)
        return style.svg(figure, "runs")


def _plot(panel: "Axes", name: str, recordings: Mapping[str, Recording]) -> None:
    for (label, recording), line in zip(recordings.items(), _lines(len(recordings)), strict=False):
        panel.plot(recording.time, recording[name], **line, label=label or "simulated")


def _lines(count: int) -> Any:
    """Colour and dashes of each variant: shades of one scale where they are too many to name."""
    if count > len(COLOURS):
        import matplotlib

        shades = matplotlib.colormaps["viridis"]
        return ({"color": shades(0.92 * k / (count - 1)), "linewidth": 1.4} for k in range(count))
    return (
        {"color": colour, "linestyle": dashes, "linewidth": 1.5}
        for colour, dashes in zip(COLOURS, cycle(DASHES), strict=False)
    )


def friction_svg(title: str, recording: Recording) -> str:
    """Return an SVG of the friction of joints and guides against speed (eqs. 1 and 2)."""
    with style.styled():
        figure, axes = style.panels(2, 2.0, share=False)
        joint, cart = recording["joint_speed"], recording["cart_speed"]
        for part, line in (("mcp", style.FIRST), ("pip", style.SECOND)):
            axes[0].plot(joint, 1e3 * recording[f"{part}_friction"], **line, label=part.upper())
        axes[0].set(xlabel="joint speed [rad/s]", ylabel="friction torque [mN m]")
        axes[0].legend(loc="upper left")
        axes[1].plot(1e3 * cart, 1e3 * recording["cart_friction"], **style.THIRD)
        axes[1].set(xlabel="cart speed [mm/s]", ylabel="guide friction [mN]")
        figure.suptitle(title, x=0.02, ha="left", fontsize=10)
        return style.svg(figure, "friction")
