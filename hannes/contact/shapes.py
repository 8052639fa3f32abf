"""Sphere, cylinder and prism, cut by each finger's plane into a rounded rectangle.

Cylinder and prism lie across the fingers (along z), unless they are tilted; a sphere off a finger's
plane gives that finger a smaller circle.
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


def frame(turn: float, tilt_x: float, tilt_y: float) -> tuple[float, float, float, float]:
    """How a tilted object's cross-section appears in a plane z = const: xx, xy, yx, yy.

    Its axis goes along (tan tilt_x, tan tilt_y, 1) [rad], turned there from z the shortest way, and
    the object about it by `turn` [rad]. Columns are the images of the cross-section's own unit
    vectors, seen along the axis.
    """
    run_x, run_y = math.tan(tilt_x), math.tan(tilt_y)
    up = 1.0 / math.sqrt(1.0 + run_x**2 + run_y**2)
    axis_x, axis_y = run_x * up, run_y * up
    tilted = axis_x * axis_y / (1.0 + up)
    first = (1.0 - axis_x**2 / (1.0 + up) + axis_x * run_x, axis_x * run_y - tilted)
    second = (axis_y * run_x - tilted, 1.0 - axis_y**2 / (1.0 + up) + axis_y * run_y)
    cosine, sine = math.cos(turn), math.sin(turn)
    return (
        cosine * first[0] + sine * second[0],
        cosine * second[0] - sine * first[0],
        cosine * first[1] + sine * second[1],
        cosine * second[1] - sine * first[1],
    )
