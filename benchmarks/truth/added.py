"""Quantities to which an effect's own file may add, without another file knowing of it.

A file of effects/ that defines a function of one of these names is called wherever the quantity is
computed; `h` is the record of parameters. What several files define is summed.
"""

from collections.abc import Callable, Sequence
from types import ModuleType

from benchmarks.truth import effects
from benchmarks.truth._jit import inlined

Quantity = Callable[..., float]
_ALL = (*effects.CATALOGUE, *effects.OUTSIDE)


def summed(name: str, files: Sequence[ModuleType] = _ALL) -> Quantity:
    """The sum of what all files add that define `name`; 0 where none does."""
    total = _nothing
    for each in files:
        if hasattr(each, name):
            total = _both(total, getattr(each, name))
    return total


@inlined
def _nothing(h, *given):
    return 0.0


def _both(one: Quantity, other: Quantity) -> Quantity:
    @inlined
    def both(h, *given):
        return one(h, *given) + other(h, *given)

    return both


# (h, angle, speed, load): torque [N m] against the rotor, at the motor's side
rotor_torque = summed("rotor_torque")
# (h, joint, angle, speed): torque [N m] on a joint (0 to 9) that opens it
joint_torque = summed("joint_torque")
# (h, shaft): loose leader wire [m] at an angle of the output shaft
loose_length = summed("loose_length")
# (h, duty, current): voltage [V] that the bus lacks
bus_drop = summed("bus_drop")
# (h, duty): share of the duty cycle that does not arrive
duty_lost = summed("duty_lost")
# (h, current): error of the current sensor [A]
current_error = summed("current_error")
