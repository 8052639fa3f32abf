"""Hunt-Crossley contact: stiffer and more damped the deeper a phalanx presses."""

import math

from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import exp_minus_one
from hannes.core.parameter import Parameter

DEPTH = 1e-3  # m, at which the stiffness is that of eq. 3


@kernel
def deepening(penetration, penetration_rate, object_stiffness, exponent, dissipation):
    """What k x (x / 1 mm)^exponent (1 + dissipation x') has beyond k x [N]."""
    if penetration <= 0.0:
        return 0.0
    growth = 1.0 + exp_minus_one(exponent * math.log(penetration / DEPTH))
    return object_stiffness * penetration * (growth * (1.0 + dissipation * penetration_rate) - 1.0)


EFFECT = Effect(
    name="hunt_crossley",
    meaning="The object gets stiffer, and damps more, the deeper it is pressed.",
    equation="F = k x (x / 1 mm)^exponent (1 + dissipation x') + beta x' ramp(x)",
    source="Hunt & Crossley (1975)",
    parameters=(
        Parameter("exponent", 0.0, "1", (0.0, 2.0), "beyond the linear law", off=0.0),
        Parameter("dissipation", 0.0, "s/m", (0.0, 10.0), "damping with depth", off=0.0),
    ),
    terms=(Term(deepening, writes=("normal_force",)),),
)
