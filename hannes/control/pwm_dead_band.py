"""PWM dead band: small duties do not reach the motor."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter


@kernel
def swallowed(duty, width):
    """Duty that is lost: -clip(duty, -width, width)."""
    return -min(max(duty, -width), width)


EFFECT = Effect(
    name="pwm_dead_band",
    meaning="The drive swallows the first part of every duty before the motor sees any.",
    equation="duty_out = duty - clip(duty, -width, width)",
    source="Jeong & Park (1991), dead time of PWM drives",
    parameters=(Parameter("width", 0.0, "1", (0.0, 0.2), "duty lost", off=0.0),),
    terms=(Term(swallowed, writes=("duty",)),),
)
