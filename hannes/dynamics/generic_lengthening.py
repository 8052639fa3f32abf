"""Generic disturbance: the leader wire lengthens from run to run, by the motor's current.

A wire creeps by its tension. That takes the current, less what friction takes: two numbers.
"""

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter

MOST = 2.5  # A


@kernel
def over_current(current, per_charge, per_time):
    """Rate of the leader's length [m/s] at a current [A]."""
    return per_charge * abs(current) + per_time


@kernel
def lengthened(motor_current, grown, charge, time, per_charge, per_time):
    """Free length [m] gained in earlier runs and in this one, and its rate [m/s]."""
    before = per_charge * charge + per_time * time
    return before + grown, over_current(motor_current, per_charge, per_time)


GENERIC = Description(
    Effect(
        name="generic_lengthening",
        meaning="The leader wire lengthens from run to run. It describes, and names no cause.",
        equation="s_L += a Q + b T + g, g' = a |i| + b; Q, T: charge and time of earlier runs",
        source="linear in current",
        parameters=(
            Parameter(
                "per_charge", 0.0, "m/(A s)", (-2e-3, 2e-3), "of the motor", "choice", off=0.0
            ),
            Parameter("per_time", 0.0, "m/s", (-1e-3, 1e-3), "of any run", "choice", off=0.0),
            Parameter(
                "charge", 0.0, "A s", (0.0, 1e7), "of the motor in earlier runs", earlier="charge"
            ),
            Parameter("time", 0.0, "s", (0.0, 1e7), "of earlier runs", earlier="time"),
        ),
        terms=(Term(lengthened, writes=("slack",), states=("grown",), unit="m"),),
        states=(Slot("grown", "m", "length gained in this run", tolerance=1e-7),),
    ),
    axis="the motor's current",
    unit="A",
    ends=(0.0, MOST),
    value="the rate at which the leader lengthens",
    value_unit="m/s",
    law=over_current,
)
