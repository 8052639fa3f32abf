"""One moment of a hand as a figure: all fingers, each in its plane, wires and carts, traces."""

import io
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.core.io.result_marks import VIEW
from hannes.report import style
from hannes.report.viewer.scene import Scene
from hannes.report.viewer.still_traces import traces
from hannes.report.viewer.still_wires import SLACK, drive, flexor, pulled, strongest, wavy
from hannes.simulation.hand.anatomy import FINGERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TURN = (-0.35, 0.55)  # rad about x, then about y, as the page shows the hand at first
MM = 1000.0
SOLID: dict[str, Any] = {"facecolor": "#cfd8e3", "edgecolor": style.BLACK, "linewidth": 0.9}
GHOST: dict[str, Any] = {
    "facecolor": "none", "edgecolor": style.VERMILLION, "linewidth": 0.9, "linestyle": "--",
}  # fmt: skip
ARROW = 0.4  # mm of arrow per N
FADED = 0.25  # opacity of a recording that is over


def still(scenes: Sequence[Scene], time: float) -> "Figure":
    """The hand at the sample nearest to `time` [s], a second scene as dashed outlines over it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 8.4), layout="constrained")
    grid = figure.add_gridspec(3, 5, height_ratios=(2.1, 1.0, 2.0))
    space = figure.add_subplot(grid[0, :])
    shown = [(each, each.nearest(time), look) for each, look in _looks(scenes, time)]
    for scene, row, look in reversed(shown):
        _space(space, scene, row, look)
    planes = [figure.add_subplot(grid[1, f]) for f in range(5)]
    most = strongest(scenes)
    for f, axes in enumerate(planes):
        for scene, row, look in shown:
            _plane(axes, scene, row, f, look, most)
        axes.set_title(_caption(scenes[0], time, f), fontsize=8.5, loc="center")
    wires = figure.add_subplot(grid[2, :3])
    drive(wires, shown, most, [each.ended(time) for each in scenes])
    for axes in (space, *planes, wires):
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.axis("off")
    traces(figure, grid[2, 3:], scenes, time)
    figure.suptitle(_title(scenes, time), x=0.02, ha="left", fontsize=9.5)
    return figure


def _looks(scenes: Sequence[Scene], time: float) -> list[tuple[Scene, dict[str, Any]]]:
    """How each scene is drawn: the first filled, the second dashed, pale where it is over."""
    looks = zip(scenes, (SOLID, GHOST), strict=False)
    return [
        (scene, {**look, "alpha": FADED} if scene.ended(time) else look) for scene, look in looks
    ]


def still_files(scenes: Sequence[Scene], time: float) -> dict[str, bytes]:
    """The same as files by suffix: `.svg` and `.png`."""
    with style.styled():
        figure, png = still(scenes, time), io.BytesIO()
        figure.savefig(png, format="png", dpi=200, metadata={"Software": VIEW})
        text = style.svg(figure, "still").replace("<svg", f"<!-- {VIEW} -->\n<svg", 1)
        return {".svg": text.encode(), ".png": png.getvalue()}


def _title(scenes: Sequence[Scene], time: float) -> str:
    """What is solid and what dashed, the leader's state, and which recording is over."""
    parts = []
    for each, kind in zip(scenes, ("", "dashed: "), strict=False):
        row = each.nearest(time)
        tension, stretch = each.tension[row, 0], each.stretch[row, 0]
        wire = f"{tension:.1f} N" if stretch > SLACK else f"slack by {-MM * stretch:.2f} mm"
        over = f"over since {each.time[-1]:.4g} s" if time > each.time[-1] else "not begun"
        parts.append(f"{kind}{each.name}, {over if each.ended(time) else 'leader ' + wire}")
    moment = scenes[0].time[scenes[0].nearest(time)] if not scenes[0].ended(time) else time
    return f"at {moment:.4f} s: {'; '.join(parts)}"


def _caption(scene: Scene, time: float, f: int) -> str:
    force = scene.forces[scene.nearest(time), 2 * f : 2 * f + 2].sum()
    shown = force > 0.05 and not scene.ended(time)
    return f"{FINGERS[f]} {force:.1f} N" if shown else FINGERS[f]


def _ends(scene: Scene, row: int, f: int) -> np.ndarray:
    """Ends of the three phalanges in the finger's plane [mm], shape (4, 2)."""
    first = scene.hand.parameters[f"{FINGERS[f]}.first_length"]
    points = scene.points[row, f]
    return MM * np.array([(-first, 0.0), (0.0, 0.0), points[:2], points[2:]])


def capsule(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """Outline of all places within `radius` of a line, shape (n, 2)."""
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    half = np.linspace(0.5 * math.pi, 1.5 * math.pi, 15) + angle
    turn = radius * np.stack([np.cos(half), np.sin(half)], axis=1)
    return np.concatenate([start + turn, end - turn])


def _plane(axes: "Axes", scene: Scene, row: int, f: int, look: dict[str, Any], most: float) -> None:
    """One finger in its plane [mm], its wire coloured by its tension [N], of at most `most`."""
    from matplotlib.patches import Polygon

    finger = FINGERS[f]
    values = scene.hand.parameters
    if scene.sections is not None:
        outline = _moved(scene, row, scene.sections.points[f])
        outline -= (values[f"{finger}.mount_x"], values[f"{finger}.mount_y"])
        outline *= (1.0, values[f"{finger}.facing"])
        rim = {**look, "edgecolor": style.GREEN if _solid(look) else style.VERMILLION}
        axes.add_patch(Polygon(MM * outline, **{**rim, "facecolor": "none"}))
    ends, radius = _ends(scene, row, f), MM * values[f"{finger}.radius"]
    for a, b in pairwise(ends):
        axes.add_patch(Polygon(capsule(a, b, radius), **look))
    _wire(axes, scene, row, f, look, most)
    for phalanx in (2 * f, 2 * f + 1):
        force = scene.forces[row, phalanx]
        if force > 0.05 and look is SOLID:  # neither of a ghost nor of what is over
            place, normal = MM * scene.contacts[row, phalanx, :2], scene.contacts[row, phalanx, 2:]
            tip = place - (4.0 + ARROW * force) * normal
            axes.annotate(
                "", tuple(tip), tuple(place), arrowprops={"arrowstyle": "->", "color": "#7a4a00"}
            )


def _wire(axes: "Axes", scene: Scene, row: int, f: int, look: dict[str, Any], most: float) -> None:
    """The flexor wire of a finger, in waves where it is slack."""
    wire = 0 if f == 4 else 1 if f < 2 else 2
    route = flexor(scene, _ends(scene, row, f))
    if scene.stretch[row, wire] < SLACK:
        route = wavy(route, 1.6)
    drawn = pulled(scene.tension[row, wire], most) if _solid(look) else {"color": style.VERMILLION}
    axes.plot(*route.T, **{"linewidth": 0.9, **drawn}, alpha=look.get("alpha"))


def _solid(look: dict[str, Any]) -> bool:
    return bool(look["facecolor"] != "none")


def _moved(scene: Scene, row: int, points: np.ndarray) -> np.ndarray:
    """An outline of the object [m] where it is at a sample, in the hand frame."""
    x, y, turn = scene.pose[row]
    cosine, sine = math.cos(turn), math.sin(turn)
    return points @ np.array([[cosine, sine], [-sine, cosine]]) + (x, y)


def _space(axes: "Axes", scene: Scene, row: int, look: dict[str, Any]) -> None:
    """All fingers, seen as the page shows them, the farthest first."""
    from matplotlib.patches import Polygon

    values, drawn = scene.hand.parameters, []
    for f, finger in enumerate(FINGERS):
        ends = _ends(scene, row, f) * (1.0, values[f"{finger}.facing"])
        ends += MM * np.array([values[f"{finger}.mount_x"], values[f"{finger}.mount_y"]])
        seen = _seen(np.column_stack([ends, np.full(4, MM * values[f"{finger}.mount_z"])]))
        radius = MM * values[f"{finger}.radius"]
        for a, b in pairwise(seen):
            drawn.append((a[2] + b[2], capsule(a[:2], b[:2], radius)))
    if scene.slices is not None:
        for z, points in zip(scene.slices.planes, scene.slices.points, strict=True):
            flat = MM * _moved(scene, row, points)
            seen = _seen(np.column_stack([flat, np.full(len(flat), MM * z)]))
            drawn.append((2.0 * seen[:, 2].mean(), seen[:, :2]))
    for _, outline in sorted(drawn, key=lambda item: item[0]):
        ring = len(outline) != 30
        shade = {"facecolor": "none", "edgecolor": style.GREEN} if ring and _solid(look) else {}
        axes.add_patch(Polygon(outline, **{**look, **shade}))


def _seen(points: np.ndarray) -> np.ndarray:
    """Points of the hand frame [mm] turned to the viewer, shape (n, 3): right, up, nearer."""
    about_x, about_y = TURN
    x, y, z = points[:, 0], -points[:, 1], points[:, 2]
    x, z = (
        x * math.cos(about_y) - z * math.sin(about_y),
        z * math.cos(about_y) + x * math.sin(about_y),
    )
    y, z = (
        y * math.cos(about_x) - z * math.sin(about_x),
        z * math.cos(about_x) + y * math.sin(about_x),
    )
    return np.column_stack([x, -y, z])
