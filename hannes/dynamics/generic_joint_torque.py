"""Generic disturbance: any torque that opens every joint, over its angle."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed

TRAVEL = 1.5  # rad, of a joint from open to closed


@kernel
def over_angle(bend, c_0, c_1, c_2, c_3, c_4):
    """Torque [N m] at an angle from rest [rad]."""
    return legendre(placed(bend, 0.0, TRAVEL), c_0, c_1, c_2, c_3, c_4)


@kernel
def torque(joint_angle, rest, c_0, c_1, c_2, c_3, c_4):
    """Torque that opens a joint [N m]."""
    return over_angle(joint_angle - rest, c_0, c_1, c_2, c_3, c_4)


GENERIC = Description(
    Effect(
        name="generic_joint_torque",
        meaning="A torque on every joint depends on its angle. It describes, and names no cause.",
        equation="T_open += sum c_k P_k(2 (q - q_rest) / travel - 1)",
        source="Legendre's polynomials",
        parameters=coefficients("N m", 0.15),
        terms=(Term(torque, writes=("spring_torque",), unit="N m"),),
    ),
    axis="every joint's angle from rest",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="a torque that opens the joint",
    value_unit="N m",
    law=over_angle,
)
