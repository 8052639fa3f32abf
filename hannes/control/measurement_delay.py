"""Measurement delay: position and current reach the controller and the log late.

A delay needs the past, which a state does not hold: here it is Pade's approximation of order 2,
which lets every frequency pass with the delay's phase to within (omega time)^5 / 720 rad. For
5 ms and what the hand does below 30 Hz that is a thousandth of a radian; steps of current that
are shorter than the delay itself come through distorted.
"""

from hannes._jit import kernel
from hannes.effect import Effect, Term
from hannes.layout import Slot
from hannes.parameter import Parameter


@kernel
def pade(now, past, change, time):
    """What a delayed signal lacks, and the rates of both states; `change` = time past'."""
    if time <= 0.0:
        return 0.0, 0.0, 0.0
    return -change, change / time, 12.0 * (now - past - 0.5 * change) / time


@kernel
def late_position(shaft_position, past_position, position_change, time):
    """Of the shaft [rad]."""
    return pade(shaft_position, past_position, position_change, time)


@kernel
def late_current(sensed_current, past_current, current_change, time):
    """Of the current [A]."""
    return pade(sensed_current, past_current, current_change, time)


EFFECT = Effect(
    name="measurement_delay",
    meaning="Position and current reach the controller and the log late.",
    equation="exp(-s time) ~ (1 - a + a^2/3) / (1 + a + a^2/3), a = s time / 2",
    source="Nilsson (1998), delays in the loop; Pade (1892), of order 2",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.01), "of the delay", off=0.0),),
    terms=(
        Term(
            late_position,
            writes=("delayed_position",),
            states=("past_position", "position_change"),
        ),
        Term(
            late_current,
            writes=("delayed_current",),
            states=("past_current", "current_change"),
        ),
    ),
    states=(
        Slot("past_position", "rad", "of the shaft", tolerance=1e-4),
        Slot("position_change", "rad", "of it, within the delay", tolerance=1e-4),
        Slot("past_current", "A", "in the sensor", tolerance=1e-4),
        Slot("current_change", "A", "of it, within the delay", tolerance=1e-4),
    ),
)
