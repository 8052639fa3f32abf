"""Breakaway: dry friction larger at rest than in motion, so that slow motions stick and slip.

`stribeck` of hannes has its peak at a speed and none at rest: there a load creeps. This one holds.
"""

import math

from hannes import Effect, Parameter, Term, kernel


@kernel
def more_at_rest(motor_speed, motor_friction_speed, torque, speed):
    """Friction beyond Coulomb's that is gone at some speeds of the motor [N m]."""
    share = motor_speed / speed
    return torque * math.tanh(motor_speed / motor_friction_speed) * math.exp(-share * share)


EFFECT = Effect(
    name="breakaway",
    meaning="Motor and gear hold at rest more than they rub in motion: they stick and slip.",
    equation="T_friction += torque tanh(w / w_s) exp(-(w / speed)^2)",
    source="Armstrong-Helouvry (1991), Stribeck friction with a level at rest",
    parameters=(
        Parameter("torque", 0.0, "N m", (0.0, 2e-3), "beyond Coulomb's, at rest", off=0.0),
        Parameter("speed", 20.0, "rad/s", (1.0, 300.0), "of the motor, at which it is gone",
                  tried=(5.0, 20.0, 80.0)),
    ),
    terms=(Term(more_at_rest, writes=("gear_friction",), unit="N m"),),
)  # fmt: skip
