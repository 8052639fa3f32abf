"""Figure of a generic disturbance: its value over its axis, with the 95 % band."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.identification.shape_words import NO_CAUSE
from hannes.report import style
from hannes.report.figure import Drawn, drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "diagnosis-shape"


def shape_figures(shape: Mapping[str, Any]) -> list[Drawn]:
    """The law of free shape that follows the recordings; none where none does."""
    if not shape or not shape["name"]:
        return []
    axis, value = shape["axis"], shape["value"]
    places, line, low, high = (
        np.array(each) for each in (axis["values"], value["values"], value["low"], value["high"])
    )

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1)
        axes.fill_between(places, low, high, color=style.SKY, alpha=0.35, linewidth=0,
                          label="95 % band")  # fmt: skip
        axes.plot(places, line, **style.FIRST, label="likeliest")
        axes.axhline(0.0, **style.MARK)
        axes.set_xlabel(_labelled(axis))
        axes.set_ylabel(_labelled({**value, "name": "value"}))  # its name is in the caption
        style.legend(axes)
        return figure

    caption = (
        f"{shape['meaning'].capitalize()}: {NO_CAUSE}. Where the band is wide, little was seen."
    )
    most = int(np.argmax(np.abs(line)))
    alt = (
        f"{shape['meaning']}: {line.min():.3g} to {line.max():.3g} {value['unit']}, largest at "
        f"{places[most]:.3g} {axis['unit']}"
    )
    return [drawn(NAME, "The shape of what is missing", caption, alt, draw)]


def _labelled(quantity: Mapping[str, Any]) -> str:
    unit = quantity["unit"]
    return quantity["name"] if unit == "1" else f"{quantity['name']} [{unit}]"
