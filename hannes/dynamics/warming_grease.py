"""Warming grease: motor and gear rub less the more work friction has done in a run."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import exp_minus_one
from hannes.core.layout import Slot
from hannes.core.parameter import Parameter
from hannes.dynamics.friction import dry


@kernel
def thinned(
    motor_speed,
    motor_dry_friction,
    motor_viscous_friction,
    motor_friction_speed,
    grease_heat,
    fall,
):
    """Friction that is missing at that heat [N m], and the rate of the heat [W]."""
    cold = dry(motor_speed, motor_dry_friction, motor_friction_speed)
    cold += motor_viscous_friction * motor_speed
    missing = cold * exp_minus_one(-fall * grease_heat)
    return missing, (cold + missing) * motor_speed


EFFECT = Effect(
    name="warming_grease",
    meaning="Friction of motor and gear falls within a run as it warms the grease.",
    equation="T_friction = T_cold exp(-fall Q), Q' = T_friction w, Q = 0 at the start",
    source="Reynolds (1886), viscosity of oils falls exponentially with heat",
    parameters=(
        Parameter("fall", 0.0, "1/J", (0.0, 10.0), "of friction by its own heat", off=0.0),
    ),
    terms=(Term(thinned, writes=("gear_friction",), states=("grease_heat",)),),
    states=(Slot("grease_heat", "J", "Q, friction work of this run", tolerance=1e-4),),
)
