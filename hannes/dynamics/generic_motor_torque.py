"""Generic disturbance: any torque on the motor over its angle, as a series of cosines."""

import math

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.parameter import Parameter

TRAVEL = 10.0  # rad at the output shaft, of a whole closure: the series is mirrored beyond


@kernel
def cosines(angle, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Sum of c_k cos(k pi angle / travel), angle at the output shaft [rad]."""
    x = math.cos(math.pi * angle / TRAVEL)
    t_2 = 2.0 * x * x - 1.0
    t_3 = 2.0 * x * t_2 - x
    t_4 = 2.0 * t_2 * t_2 - 1.0
    t_5 = 2.0 * x * t_4 - t_3
    t_6 = 2.0 * t_3 * t_3 - 1.0
    return c_0 + c_1 * x + c_2 * t_2 + c_3 * t_3 + c_4 * t_4 + c_5 * t_5 + c_6 * t_6


@kernel
def torque(motor_angle, gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Torque on the rotor [N m]."""
    return cosines(motor_angle / gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6)


def waves(unit: str, most: float) -> tuple[Parameter, ...]:
    """The seven coefficients."""
    return tuple(
        Parameter(f"c_{k}", 0.0, unit, (-most, most), f"of cosine {k}", "choice", off=0.0)
        for k in range(7)
    )


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
    law=cosines,
)
