"""The flat record that the compiled kernels read."""

from collections import namedtuple
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.truth.parameters import NOMINAL, fields

_SECTION = ("section_radius", "section_x", "section_y")  # per finger, in its own plane
_OBJECT = ("object_stiffness", "object_damping", "object_friction")
_HIDDEN = ("slack", "asymmetry", "load_loss")
# Built from NOMINAL so that a parameter has one home; dots become underscores.
Hand = namedtuple(
    "Hand", [name.replace(".", "_") for name in NOMINAL] + [*_SECTION, *_OBJECT, *_HIDDEN]
)


def section(
    thing: Mapping[str, Any] | None, hand: Mapping[str, Any]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Radius and centre (m) of the object's cut by each finger's plane; radius 0 where it misses.

    A cylinder's axis is z, across the fingers; a sphere's cut shrinks off its centre.
    """
    if thing is None:
        return np.zeros(5), np.zeros(5), np.zeros(5)
    if thing["shape"] not in ("cylinder", "sphere"):
        raise ValueError(f"expected shape cylinder or sphere, came {thing['shape']}")
    x, y, z = thing["position"]
    off = hand["fingers_plane_z"] - z if thing["shape"] == "sphere" else np.zeros(5)
    radius = np.sqrt(np.maximum(thing["radius"] ** 2 - off**2, 0.0))
    return (
        radius,
        x - hand["fingers_origin_x"],
        hand["fingers_side"] * (y - hand["fingers_origin_y"]),
    )


def pack(
    parameters: Mapping[str, Any],
    thing: Mapping[str, Any] | None = None,
    slack: float = 0.0,
    asymmetry: float = 0.0,
    load_loss: float = 0.0,
) -> Hand:
    """Everything the kernels need; the gear's nominal and hidden load losses add."""
    hand = fields(parameters)
    contact = thing or {"stiffness": 0.0, "damping": 0.0, "friction": 0.0}
    return Hand(
        **hand,
        **dict(zip(_SECTION, section(thing, hand), strict=True)),
        **{name: float(contact[name.removeprefix("object_")]) for name in _OBJECT},
        slack=float(slack),
        asymmetry=float(asymmetry),
        load_loss=hand["gear_load_loss"] + float(load_loss),
    )
