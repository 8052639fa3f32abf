"""Sphere, cylinder and prism, cut by each finger's plane into a rounded rectangle.

Cylinder and prism lie across the fingers (along z); a sphere off a finger's plane gives that
finger a smaller circle.
"""

import math
from collections.abc import Callable, Sequence

Section = tuple[float, float, float]


def _sphere(radius: float, half_x: float, half_y: float, offset: float) -> Section:
    return 0.0, 0.0, math.sqrt(max(radius**2 - offset**2, 0.0))


def _cylinder(radius: float, half_x: float, half_y: float, offset: float) -> Section:
    return 0.0, 0.0, radius


def _prism(radius: float, half_x: float, half_y: float, offset: float) -> Section:
    rounding = min(radius, half_x, half_y)
    return half_x - rounding, half_y - rounding, rounding


SHAPES: dict[str, Callable[[float, float, float, float], Section]] = {
    "sphere": _sphere,
    "cylinder": _cylinder,
    "prism": _prism,
}


def sections(
    shape: str, radius: float, half_x: float, half_y: float, offsets: Sequence[float]
) -> list[Section]:
    """Core half sizes and radius [m] of the section at each plane's distance `offsets` [m]."""
    return [SHAPES[shape](radius, half_x, half_y, offset) for offset in offsets]
