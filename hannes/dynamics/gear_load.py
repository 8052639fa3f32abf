"""Load-dependent gear friction: the reducer loses a share of what it transmits."""

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter


@kernel
def load_loss(motor_speed, motor_friction_speed, load, coefficient):
    """Friction proportional to the transmitted load: mu |tl| tanh(w / w_s) [N m]."""
    return coefficient * abs(load) * soft_sign(motor_speed / motor_friction_speed)


EFFECT = Effect(
    name="gear_load",
    meaning="The reducer's teeth rub harder the more torque they carry.",
    equation="T_friction += coefficient |tl| tanh(w / w_s)",
    source="Armstrong & Canudas de Wit (1995), load-dependent friction of gears",
    parameters=(Parameter("coefficient", 0.0, "1", (0.0, 0.5), "share lost", "choice", off=0.0),),
    terms=(Term(load_loss, writes=("gear_friction",)),),
)
