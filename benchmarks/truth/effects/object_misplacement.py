"""Object misplacement: the object stands elsewhere than the bench's drawing has it.

    centre = (object.x + x, object.y + y)

in the hand frame: x along the palm to the fingertips, y out of the palm (towards the fingers'
backs). In free closing it shows nothing. Source: geometry. Range: 0.3 to 8 mm, both signs.
"""

from benchmarks.truth.size import Size

SIZES = {"x": Size("m", -8e-3, 8e-3), "y": Size("m", -8e-3, 8e-3)}


def placed(position: tuple[float, ...], x: float, y: float) -> tuple[float, ...]:
    """Where the object stands (m) that should stand at `position`."""
    return position[0] + x, position[1] + y, *position[2:]
