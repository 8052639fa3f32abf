"""Generic disturbance: any torque on the motor over its angle, as a series of cosines."""

from hannes.core.description import Description, waves
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import cosines

TRAVEL = 10.0  # rad at the output shaft, of a whole closure: the series is mirrored beyond


@kernel
def over_angle(angle, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Value at an angle of the output shaft [rad], in the coefficients' unit."""
    return cosines(angle / TRAVEL, c_0, c_1, c_2, c_3, c_4, c_5, c_6)


@kernel
def torque(motor_angle, gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Torque on the rotor [N m]."""
    return over_angle(motor_angle / gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6)


GENERIC = Description(
    Effect(
        name="generic_motor_torque",
        meaning="A torque on the motor depends on its angle. It describes, and names no cause.",
        equation="J w' += sum c_k cos(k pi th / (N travel))",
        source="Fourier's series",
        parameters=waves("N m", 0.01),
        terms=(Term(torque, writes=("motor_torque",), unit="N m"),),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="a torque on the motor",
    value_unit="N m",
    law=over_angle,
)
