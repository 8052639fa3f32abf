"""Measurement delay: position and current reach the controller and the log late.

Exact where the controller is sampled: the firmware reads, at each tick, what was true before, and
the log has what it read. The continuous controller would need the past, which a state does not
hold: there it is Pade's approximation of order 2, which lets every frequency pass with the
delay's phase to within (omega time)^5 / 720 rad. For 5 ms and what the hand does below 30 Hz that
is a thousandth of a radian; what changes within the delay itself comes through distorted.
"""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter


@kernel
def pade(now, past, change, time):
    """What a delayed signal lacks, and the rates of both states; `change` = time past'."""
    if time <= 0.0:
        return 0.0, 0.0, 0.0
    return -change, change / time, 12.0 * (now - past - 0.5 * change) / time


@kernel
def late_position(
    shaft_position, held_position, controller_sampled, past_position, position_change, time
):
    """Of the shaft [rad]; `held_position` is what the firmware last read."""
    if controller_sampled > 0.5 and time > 0.0:
        return held_position - shaft_position, 0.0, 0.0
    return pade(shaft_position, past_position, position_change, time)


@kernel
def late_current(
    sensed_current, held_current, controller_sampled, past_current, current_change, time
):
    """Of the current [A]."""
    if controller_sampled > 0.5 and time > 0.0:
        return held_current - sensed_current, 0.0, 0.0
    return pade(sensed_current, past_current, current_change, time)


@kernel
def age(time):
    """Of what the firmware reads [s]."""
    return time


EFFECT = Effect(
    name="measurement_delay",
    meaning="Position and current reach the controller and the log late.",
    equation="m(t - time); continuous (1 - a + a^2/3) / (1 + a + a^2/3), a = s time / 2",
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
        Term(age, writes=("reading_age",)),
    ),
    states=(
        Slot("past_position", "rad", "of the shaft", tolerance=1e-4),
        Slot("position_change", "rad", "of it, within the delay", tolerance=1e-4),
        Slot("past_current", "A", "in the sensor", tolerance=1e-4),
        Slot("current_change", "A", "of it, within the delay", tolerance=1e-4),
    ),
)
