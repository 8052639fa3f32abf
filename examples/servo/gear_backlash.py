"""Backlash: play between gear and shaft, which a light load leaves where it is and a heavy moves.

The shaft is without inertia. Where gravity does not overcome its own friction it stays until a
face of the gear pushes it. Where gravity does, it falls onto the other face.
"""

import math

from hannes import Effect, Parameter, Slot, Term, kernel

FALL = 20.0  # rad/s per N m beyond its friction, of a free shaft: quick beside any command
FACE = 2e4  # 1/s, at which a face stops the shaft
LEAST = 1e-4  # rad, half of the gap that a place is counted in


@kernel
def lag(motor_angle, motor_speed, gear_ratio, gravity_torque, gravity_angle, place, gap, hold):
    """How far the shaft is ahead of the gear [rad], and the rate of its place in the gap."""
    turn = motor_angle / gear_ratio
    torque = gravity_torque * math.sin(turn + gravity_angle)
    falling = -FALL * max(abs(torque) - hold, 0.0) * math.tanh(torque / hold)
    within = min(max(place, -1.0), 1.0)
    rate = (falling - motor_speed / gear_ratio) / max(0.5 * gap, LEAST)
    return 0.5 * gap * within, rate - FACE * (place - within)


EFFECT = Effect(
    name="gear_backlash",
    meaning="Gear and shaft have play: the shaft stays or falls before it is pushed on.",
    equation="q = th / N + z, |z| <= gap / 2, free within",
    source="Nordin & Gutman (2002), backlash with a load that is held or falls",
    parameters=(
        Parameter("gap", 0.0, "rad", (0.0, 0.1), "whole play, at the shaft", off=0.0),
        Parameter("hold", 0.02, "N m", (2e-3, 0.5), "friction of the shaft alone"),
    ),
    terms=(Term(lag, writes=("shaft_position",), states=("place",)),),
    states=(Slot("place", "1", "of the shaft in the gap, from -1 to 1", tolerance=1e-3),),
)
