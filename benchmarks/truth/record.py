"""The flat record that the compiled kernels read: parameters, object, hidden effects."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.truth.effects import SIZES
from benchmarks.truth.effects.object_misplacement import placed
from benchmarks.truth.parameters import NOMINAL, OWN, named

_SECTION = ("section_radius", "section_x", "section_y")  # per finger, in its own plane
# Built from NOMINAL and SIZES so that a parameter has one home; dots become underscores.
_BOX = ("section_half_x", "section_half_y")  # of a prism, within its rounded edges
_ONE = [name for name in (*NOMINAL, *SIZES, *_BOX) if not name.startswith("fingers.")]
_FIVE = [*(name for name in NOMINAL if name.startswith("fingers.")), *_SECTION, *OWN]
_ALIKE = dict.fromkeys(OWN, (1.0,) * 5)
HALVES = ("half_x", "half_y")
SHAPES = ("cylinder", "sphere", "prism")
LAYOUT = np.dtype(
    [(name.replace(".", "_"), float) for name in _ONE]
    + [(name.replace(".", "_"), float, 5) for name in _FIVE]
)


def checked(effects: Mapping[str, float]) -> dict[str, float]:
    """Every effect's parameters by full name; those not given at their defaults.

    Raises ValueError for a name that no effect has.
    """
    for name in effects:
        if name not in SIZES:
            raise ValueError(f"no effect has {name}; expected one of {', '.join(SIZES)}")
    return {name: float(effects.get(name, size.default)) for name, size in SIZES.items()}


def posed(values: Mapping[str, Any], thing: Mapping[str, Any] | None) -> dict[str, Any]:
    """The hand's values with the object's own in place; `position` stands for x, y, z."""
    own = {k: v for k, v in (thing or {}).items() if k not in ("shape", "position")}
    place = zip("xyz", (thing or {}).get("position", ()), strict=False)
    return named({**values, **{f"object.{k}": v for k, v in (*own.items(), *place)}})


def sections(values: Mapping[str, Any], shape: str, hidden: Mapping[str, float]) -> np.ndarray:
    """Radius and centre (m) of the object's cut by each finger's plane, shape (3, 5).

    A cylinder's axis is z, across the fingers, as is a prism's, whose radius is that of its edges;
    a sphere's cut shrinks off its centre; radius 0 where it misses.
    """
    if shape not in SHAPES:
        raise ValueError(f"expected shape {', '.join(SHAPES)}, came {shape}")
    x, y = placed(
        (values["object.x"], values["object.y"]),
        hidden["object_misplacement.x"],
        hidden["object_misplacement.y"],
    )
    off = np.array(values["fingers.plane_z"]) - values["object.z"]
    radius = values["object.radius"] ** 2 - (off**2 if shape == "sphere" else 0.0 * off)
    return np.array(
        [
            np.sqrt(np.maximum(radius, 0.0)),
            x - np.array(values["fingers.origin_x"]),
            np.array(values["fingers.side"]) * (y - np.array(values["fingers.origin_y"])),
        ]
    )


def pack(
    parameters: Mapping[str, Any],
    thing: Mapping[str, Any] | None = None,
    effects: Mapping[str, float] | None = None,
) -> np.record:
    """Everything the kernels need: parameters (any subset; the rest nominal), object, effects."""
    values, hidden = {**_ALIKE, **posed(parameters, thing)}, checked(effects or {})
    cut = sections(values, thing["shape"], hidden) if thing else np.zeros((3, 5))
    if thing and thing["shape"] == "prism":
        least = min(values["object.radius"], values["object.half_x"], values["object.half_y"])
        hidden |= {f"section_{side}": values[f"object.{side}"] - least for side in HALVES}
        cut[0] = least
    record = np.rec.array(np.zeros(1, LAYOUT))[0]
    for name, value in {**values, **hidden, **dict(zip(_SECTION, cut, strict=True))}.items():
        record[name.replace(".", "_")] = value
    return record
