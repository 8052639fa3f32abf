"""The page of `hannes view`: data, drawing and libraries in one file that asks for nothing else."""

import hashlib
import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hannes.core.errors import ComputationFailed
from hannes.report.page import environment
from hannes.report.schematic_layout import layout
from hannes.report.viewer.geometry import Outlines
from hannes.report.viewer.packing import exact, whole
from hannes.report.viewer.scene import Scene
from hannes.simulation.hand.anatomy import FINGERS

HERE = Path(__file__).parent
# What a whole number in the page's data stands for.
LENGTH, FINE, FORCE, ANGLE = 4e-6, 1e-6, 0.01, 1e-4  # m, m, N, rad


def page(title: str, scenes: Sequence[Scene], without: Scene | None = None) -> str:
    """The page of one or two scenes, the second drawn as a ghost over the first.

    `without` is the last scene without its effects, which a switch shows as the ghost in its place.
    """
    shown = [*scenes, *([without] if without else [])]
    second = 1 if len(scenes) > 1 else None
    data = {
        "title": title,
        "fingers": list(FINGERS),
        "scenes": [_packed(each) for each in shown],
        "ghost": {"with": second, "without": len(scenes) if without else None},
        "layout": layout(),
    }
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    made = environment()
    return made.get_template("viewer.html.j2").render(
        title=title,
        data=text,
        notes=[(each.name, each.note) for each in shown],
        vendor=vendor(),
        script=_script(),
        style=(HERE / "viewer.css").read_text(encoding="utf-8"),
    )


def _script() -> str:
    """The page's own script, its parts in their order."""
    parts = sorted((HERE / "script").glob("*.js"))
    return "\n".join(each.read_text(encoding="utf-8") for each in parts)


def vendor() -> dict[str, str]:
    """Text of the browser libraries by file name; ComputationFailed where one was altered."""
    folder, found = HERE / "vendor", {}
    for each in tomllib.loads((folder / "vendor.toml").read_text(encoding="utf-8")).values():
        for name, digest in each["files"].items():
            content = (folder / name).read_bytes()
            if hashlib.sha256(content).hexdigest() != digest:
                raise ComputationFailed(
                    f"{folder / name} is not the file that was shipped: install hannes anew"
                )
            found[name] = content.decode()
    return found


def _packed(scene: Scene) -> dict[str, Any]:
    """What the page needs of a scene: packed arrays by name, and numbers that do not change."""
    values = scene.hand.parameters
    return {
        "name": scene.name,
        "drawnBy": scene.drawn_by,
        "own": scene.own,
        "effects": ", ".join(each.name for each in scene.hand.present_effects()),
        "every": scene.every,
        "time": exact(scene.time),
        "points": whole(scene.points, LENGTH),
        "contacts": whole(scene.contacts[:, :, :2], LENGTH),
        "pushes": whole(scene.contacts[:, :, 2:] * scene.forces[:, :, np.newaxis], FORCE),
        "carts": whole(scene.carts, FINE),
        "motor": whole(scene.motor, ANGLE),
        "pose": whole(scene.pose, FINE),
        "tension": whole(scene.tension, FORCE),
        "stretch": whole(scene.stretch, FINE),
        "recorded": {name: exact(each) for name, each in scene.recorded.items()},
        "simulated": {name: whole(each, _quantum(each)) for name, each in scene.simulated.items()},
        "units": dict(scene.units),
        "mounts": [
            [values[f"{finger}.{name}"] for name in ("mount_x", "mount_y", "mount_z", "facing")]
            + [values[f"{finger}.{name}"] for name in ("first_length", "radius")]
            for finger in FINGERS
        ],
        "arms": [values["mcp.moment_arm"], values["pip.moment_arm"]],
        "sections": _outlined(scene.sections),
        "slices": _outlined(scene.slices),
    }


def _quantum(values: np.ndarray) -> float:
    """A millionth of the largest value, the quantum of simulated traces."""
    return max(float(np.abs(values).max()), 1e-9) * 1e-6


def _outlined(drawn: Outlines | None) -> dict[str, Any] | None:
    if drawn is None:
        return None
    return {
        "planes": drawn.planes.round(6).tolist(),
        "points": drawn.points.round(6).tolist(),
    }
