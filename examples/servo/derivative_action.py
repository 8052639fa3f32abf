"""Derivative action: the firmware brakes by the shaft's speed, before it clips the duty.

A motor brakes by its back EMF at any speed. This brakes where the duty is not at its limit, so a
servo runs at full speed until it is near, and then comes in slowly. A Feetech STS3215 has such a
number in its register 22, and LeRobot sets it to 32 beside a gain of 16.
"""

from hannes import Effect, Parameter, Term, kernel


@kernel
def braked(motor_speed, gear_ratio, time):
    """Where the controller steers to beside the command [rad], for the speed of the shaft."""
    return -time * motor_speed / gear_ratio


EFFECT = Effect(
    name="derivative_action",
    meaning="The firmware brakes by the shaft's speed, as long as its duty is not at the limit.",
    equation="duty = clip(gain (r - q - time q'))",
    source="Astrom & Murray (2008), derivative action on what is measured",
    parameters=(Parameter("time", 0.0, "s", (0.0, 0.2), "of the derivative", off=0.0),),
    terms=(Term(braked, writes=("aside",), unit="rad"),),
)
