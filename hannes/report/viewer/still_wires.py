"""Motor, carts and wires of one moment, as in the schematic: slack wires are wavy."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.report import style
from hannes.report.schematic_layout import layout
from hannes.report.viewer.scene import WIRES, Scene
from hannes.simulation.hand.anatomy import FINGERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MM = 1000.0
WAVES = 26
SLACK = -1e-6  # m of stretch below which a wire is drawn slack, as the page has it
LOOSE, TIGHT = np.array([120, 150, 180]) / 255, np.array([120, 0, 25]) / 255  # colours of wires

Shown = tuple[Scene, int, dict[str, Any]]  # a scene, its row, and how its parts are drawn


def strongest(scenes: Sequence[Scene]) -> float:
    """The largest tension of all wires and times, at least 1 N."""
    return max(1.0, *(float(each.tension.max()) for each in scenes))


def pulled(tension: float, most: float) -> dict[str, Any]:
    """How a wire looks: darker and thicker the harder it is pulled [N]."""
    share = min(1.0, max(0.0, tension / most))
    return {"color": tuple(LOOSE + share * (TIGHT - LOOSE)), "linewidth": 0.9 + 2.0 * share}


def wavy(route: np.ndarray, height: float) -> np.ndarray:
    """A route, shape (n, 2), in waves of a height in its own unit."""
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    count = np.arange(4 * WAVES + 1)
    at = places[-1] * count / count[-1]
    points = np.column_stack([np.interp(at, places, route[:, k]) for k in range(2)])
    along = np.gradient(points, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    ends = np.minimum(1.0, np.minimum(count, count[::-1]) / 4.0)
    aside = height * np.sin(0.5 * math.pi * count) * ends
    return points + aside[:, np.newaxis] * np.column_stack([-along[:, 1], along[:, 0]])


def flexor(scene: Scene, ends: np.ndarray) -> np.ndarray:
    """Wire along a finger [mm]: on the closing side of its links, at the joints' moment arms.

    ends: of the three phalanges, shape (4, 2).
    """
    near, far = (MM * scene.hand.parameters[f"{joint}.moment_arm"] for joint in ("mcp", "pip"))
    sides = []
    for (a, b), (first, last) in zip(
        pairwise(ends), ((near, near), (near, max(far, 8.0)), (8.0, 8.0)), strict=True
    ):
        x, y = (b - a) / np.linalg.norm(b - a)
        below = np.array([y, -x])
        sides.append([a + first * below, b + last * below])
    stop = sides[2][0] + 0.6 * (sides[2][1] - sides[2][0])
    return np.array([*sides[0], *sides[1], stop])


def drive(axes: "Axes", shown: Sequence[Shown], most: float, over: Sequence[bool]) -> None:
    """Motor, carts where they are, and wires, with their numbers of the first scene."""
    drawn = layout()
    for scene, row, look in reversed(shown):
        _drive(axes, scene, row, look, most, drawn)
    if not over[0]:
        _labels(axes, *shown[0][:2], drawn)
    for finger in FINGERS:
        x, y = drawn["fingers"][finger]
        axes.text(x + 8, -y - 24, finger, fontsize=7.5)
    axes.plot([40, 560], [-30, -460], alpha=0.0)  # room for the texts


def _drive(
    axes: "Axes",
    scene: Scene,
    row: int,
    look: dict[str, Any],
    most: float,
    drawn: dict[str, Any],
) -> None:
    from matplotlib.patches import Circle, Rectangle

    gone = drawn["travel"] * scene.carts[row]
    solid, alpha = look["facecolor"] != "none", look.get("alpha")
    for (x, y), way in zip(drawn["carts"].values(), gone, strict=True):
        axes.add_patch(Rectangle((x - 56 - way, -y - 34), 112, 64, **look))
        for side in (-32, 32):
            axes.add_patch(Circle((x + side - way, -y), drawn["wheel"] - 2, **look))
    x, y = drawn["motor"]
    angle = scene.motor[row]
    axes.add_patch(Circle((x, -y), drawn["wheel"], **look))
    hand = drawn["wheel"] * np.array([math.cos(angle), -math.sin(angle)])
    axes.plot([x, x + hand[0]], [-y, -y + hand[1]], color=look["edgecolor"], alpha=alpha, lw=1.2)
    ways = {"": 0.0, "a": gone[0], "b": gone[1]}
    for k, name in enumerate(WIRES):
        route = np.array([(px - ways[cart], -py) for px, py, cart in drawn["wires"][name]])
        if scene.stretch[row, k] < SLACK:
            route = wavy(route, 7.0)
        pull = pulled(scene.tension[row, k], most)
        ghost = {"color": style.VERMILLION, "linestyle": "--"}
        axes.plot(*route.T, **(pull if solid else {**pull, **ghost}), alpha=alpha)


def _labels(axes: "Axes", scene: Scene, row: int, drawn: dict[str, Any]) -> None:
    """Tension of each wire, or by how much it is slack; way of each cart."""

    def wire(k: int, name: str) -> str:
        slack = -MM * scene.stretch[row, k]
        return (
            f"{name} slack {slack:.2f} mm"
            if scene.stretch[row, k] < SLACK
            else f"{name} {scene.tension[row, k]:.1f} N"
        )

    a = drawn["carts"]["a"][1]
    axes.text(drawn["motor"][0], -a - 40, "motor", fontsize=7.5, ha="center")
    axes.text(140, -a - 92, wire(0, "leader"), fontsize=7.5)
    for k, (name, (x, y)) in enumerate(drawn["carts"].items()):
        way = f"cart {name.upper()} {MM * scene.carts[row, k]:z.2f} mm"
        axes.text(x + 30, -y - 54, way, fontsize=7.5, ha="right")
        axes.text(x + 66, -y - 4, wire(1 + k, "follower"), fontsize=7.5)
