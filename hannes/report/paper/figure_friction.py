"""Fig. 2: equations 1 and 2 at the joints and at the guides."""

from typing import TYPE_CHECKING

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.formats import number
from hannes.simulation.experiment.friction_curve import friction as friction_of
from hannes.simulation.hand.hand import Hand

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def friction(hand: Hand) -> Drawn:
    """Draw the curves of MCP, PIP and guide."""
    arm = hand.parameters["mcp.breakaway_friction"] * 1e3
    return drawn(
        "fig2",
        "Fig. 2: friction against speed",
        "Equations 1 and 2 with the shipped values: a breakaway peak, the Coulomb level, a viscous "
        "rise. The circle marks the breakaway velocity.",
        f"Two panels. Friction torque of MCP and PIP joints against joint speed: both rise steeply "
        f"through zero, peak near 10 rad/s (MCP {number(arm)} mN m) and settle on a slowly rising "
        "level. Friction force of a linear guide against its speed, of the same form.",
        lambda: _draw(hand),
    )


def _draw(hand: Hand) -> "Figure":
    figure, (joints, guide) = style.panels(2, share=False)
    _curve(joints, hand, "mcp", "MCP joint", 40.0, 1.0, style.FIRST)
    _curve(joints, hand, "pip", "PIP joint", 40.0, 1.0, style.SECOND)
    joints.set(xlabel="joint speed [rad/s]", ylabel="friction torque [mN m]")
    _curve(guide, hand, "cart", "linear guide", 0.04, 1e3, style.FIRST)
    guide.set(xlabel="cart speed [mm/s]", ylabel="friction force [mN]")
    for axes in (joints, guide):
        axes.axhline(0.0, **style.MARK)
        style.legend(axes)
    return figure


def _curve(
    axes: "Axes", hand: Hand, part: str, label: str, reach: float, scale: float, line: dict
) -> None:
    speeds = np.linspace(-reach, reach, 801)
    axes.plot(speeds * scale, friction_of(hand, part, speeds) * 1e3, label=label, **line)
    peak = np.array([hand.parameters[f"{part}.breakaway_speed"]])
    axes.plot(
        peak * scale,
        friction_of(hand, part, peak) * 1e3,
        "o",
        color=line["color"],
        markerfacecolor="white",
    )
