"""A fault of one finger's joint, put into a hand after it was drawn.

Ranges are physical: a spring that lost a third up to one that is gone, a wire that runs at another
arm, a joint two to ten times as stiff as it was, a stop that moved by a third up to most of the
travel.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.truth.parameters import FINGERS

FRICTION = ("breakaway_friction", "coulomb_friction", "viscous_friction")
# Kind -> least and largest size: share lost, share lost, share added, rad added to the stop.
RANGES = {
    "weak_spring": (0.3, 1.0),
    "slipped_wire": (0.15, 0.5),
    "stiff_joint": (1.0, 10.0),
    "moved_stop": (-0.9, -0.3),
}


@dataclass(frozen=True)
class Fault:
    """kind: of RANGES;  finger: of FINGERS;  joint: mcp or pip;  size: see RANGES."""

    kind: str
    finger: str
    joint: str
    size: float


def broken(values: Mapping[str, Any], fault: Fault) -> dict[str, Any]:
    """The hand with that fault."""
    out = dict(values)
    if fault.kind == "moved_stop":
        _change(out, f"fingers.{fault.joint}_upper", fault, 1.0, fault.size)
    if fault.kind == "weak_spring":
        for what in ("spring_stiffness", "spring_preload"):
            _change(out, f"finger_share.{fault.joint}_{what}", fault, 1.0 - fault.size)
    if fault.kind == "slipped_wire":
        _change(out, f"finger_share.{fault.joint}_moment_arm", fault, 1.0 - fault.size)
    if fault.kind == "stiff_joint":
        for what in FRICTION:
            _change(out, f"finger_share.{fault.joint}_{what}", fault, 1.0 + fault.size)
    return out


def _change(
    values: dict[str, Any], name: str, fault: Fault, factor: float, more: float = 0.0
) -> None:
    row = list(values.get(name, (1.0,) * len(FINGERS)))
    place = FINGERS.index(fault.finger)
    row[place] = row[place] * factor + more
    values[name] = tuple(row)
