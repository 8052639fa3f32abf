"""Torque ripple: cogging of the motor, a torque that goes round with the rotor."""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

WHOLE = tuple(
    float(count) for count in range(1, 13)
)  # in a turn; more are too quick for recordings
QUARTERS = (0.0, math.pi / 2.0)


@kernel
def ripple(motor_angle, amplitude, cycles, phase):
    """Torque on the rotor [N m]: amplitude sin(cycles th + phase)."""
    return amplitude * math.sin(cycles * motor_angle + phase)


EFFECT = Effect(
    name="torque_ripple",
    meaning="The motor's torque goes up and down as the rotor turns past its magnets.",
    equation="J w' += amplitude sin(cycles th + phase)",
    source="Jahns & Soong (1996), pulsating torque of permanent-magnet motors",
    parameters=(
        Parameter("amplitude", 0.0, "N m", (0.0, 0.01), "motor side", off=0.0),
        Parameter("cycles", 4.0, "1", (0.5, 100.0), "periods in a motor turn", tried=WHOLE),
        Parameter(
            *("phase", 0.0, "rad", (-6.3, 6.3), "at the motor's angle 0"),
            tried=QUARTERS,
            turns=math.pi,
        ),
    ),
    terms=(Term(ripple, writes=("motor_torque",), unit="N m"),),
)
