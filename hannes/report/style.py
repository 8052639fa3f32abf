"""How every figure looks: colours, lines, sizes, and SVG whose bytes depend on the data alone.

Colours are Okabe & Ito's (2008), which survive colour blindness; every line also has its own
dashes, which survive a grey print. Text stays text in the SVG: it can be read, searched and
selected, with fonts that any system has.
"""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
ORANGE, SKY, PURPLE, BLACK, GREY = "#E69F00", "#56B4E9", "#CC79A7", "#000000", "#6e6e6e"

WIDTH = 4.6  # inch; text of 9 pt stays legible when a phone shows it at 0.75 of this
PANEL = 2.05  # inch, height of one panel

FIRST: dict[str, Any] = {"color": BLUE, "linestyle": "-", "linewidth": 1.8}
SECOND: dict[str, Any] = {"color": VERMILLION, "linestyle": (0, (5, 2)), "linewidth": 1.8}
THIRD: dict[str, Any] = {"color": GREEN, "linestyle": (0, (4, 1.5, 1, 1.5)), "linewidth": 1.8}
FAINT: dict[str, Any] = {"color": SKY, "linewidth": 1.0}
# Published numbers look like nothing that was simulated: black or grey, thick and short.
PUBLISHED: dict[str, Any] = {"color": BLACK, "linestyle": (0, (1.5, 1)), "linewidth": 2.4}
PUBLISHED_MODEL: dict[str, Any] = {"color": GREY, "linestyle": (0, (1, 1)), "linewidth": 1.8}
MARK: dict[str, Any] = {"color": GREY, "linestyle": ":", "linewidth": 1.0}

RC: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.handlelength": 3.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "lines.solid_capstyle": "round",
    "lines.dash_capstyle": "butt",
    "path.simplify": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "hannes",
    "text.parse_math": False,  # a title may hold dollars
}

# Verdana has the widths of DejaVu Sans; the rest is for systems that lack both.
FONTS = "'DejaVu Sans', Verdana, 'Segoe UI', Arial, sans-serif"
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


@contextmanager
def styled() -> Iterator[None]:
    """Draw with this style inside the block, whatever the user's matplotlibrc says."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        for name, value in RC.items():
            matplotlib.rcParams[name] = value  # type: ignore[index]
        yield


def panels(
    rows: int, height: float = PANEL, *, share: bool = True
) -> tuple["Figure", list["Axes"]]:
    """Return a figure and its `rows` panels one above the other, `height` [inch] each."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, rows * height + 0.25), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=share, squeeze=False)[:, 0]
    return figure, list(axes)


def legend(axes: "Axes", **options: Any) -> None:
    """Put the legend above the panel, where it hides no data."""
    placed = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.1, "ncols": 2}
    axes.legend(**{**placed, **options})


def svg(figure: "Figure", name: str) -> str:
    """Return the figure as a standalone SVG; ids begin with `name`, so several fit in one page."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=_NO_METADATA)
    text = buffer.getvalue()
    text = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', text)
    text = re.sub(r"url\(#([^)]+)\)", rf"url(#{name}-\1)", text)
    text = re.sub(r'href="#([^"]+)"', rf'href="#{name}-\1"', text)
    return text.replace("'DejaVu Sans'", FONTS)
