"""Generic disturbance: any friction of every joint, over its angle."""

import math

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.dynamics.generic_joint_torque import TRAVEL, over_angle

SLOW = 0.2  # rad/s, below which friction changes sign smoothly


@kernel
def friction(joint_angle, joint_speed, rest, c_0, c_1, c_2, c_3, c_4):
    """Torque against a joint's motion [N m]."""
    return math.tanh(joint_speed / SLOW) * over_angle(joint_angle - rest, c_0, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_joint_friction",
        meaning="The friction of every joint depends on its angle. It describes, and names no "
        "cause.",
        equation="T_open += tanh(q' / v0) sum c_k P_k(2 (q - q_rest) / travel - 1)",
        source="Legendre's polynomials",
        parameters=coefficients("N m", 0.05),
        terms=(Term(friction, writes=("spring_torque",), unit="N m"),),
    ),
    axis="every joint's angle from rest",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="further friction of the joint",
    value_unit="N m",
    law=over_angle,
)
