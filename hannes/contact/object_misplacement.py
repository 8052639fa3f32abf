"""Object misplacement: the object is not where the experiment says."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def moved(x, y):
    """Shift of the object in the hand frame [m]."""
    return x, y


EFFECT = Effect(
    name="object_misplacement",
    meaning="The object lies a little beside the place that the experiment says.",
    equation="object.x += x, object.y += y",
    source="Dollar & Howe (2010), grasps with an error of placement",
    parameters=(
        Parameter("x", 0.0, "m", (-0.02, 0.02), "towards the fingertips", off=0.0),
        Parameter("y", 0.0, "m", (-0.02, 0.02), "out of the palm", off=0.0),
    ),
    terms=(Term(moved, writes=("object_x", "object_y")),),
)
