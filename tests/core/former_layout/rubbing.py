"""An effect of a user's own on the hand, as docs described it before the packages."""

from hannes._jit import kernel
from hannes.effect import Effect, Term
from hannes.layout import Slot
from hannes.parameter import Parameter


@kernel
def rub(motor_speed, heat, size, time):
    """Friction [N m] that grows while the motor turns, and its rate."""
    return size * heat * motor_speed, (abs(motor_speed) - heat) / time


EFFECT = Effect(
    name="rubbing",
    meaning="A bearing that rubs harder the longer it turns.",
    equation="T_friction += size h w; time h' = |w| - h",
    source="none (2026)",
    parameters=(
        Parameter("size", 0.0, "N m s2/rad2", (0.0, 1e-6), "of it", off=0.0),
        Parameter("time", 0.1, "s", (0.01, 1.0), "to grow"),
    ),
    terms=(Term(rub, writes=("gear_friction",), states=("heat",)),),
    states=(Slot("heat", "rad/s", "of the bearing"),),
)
