"""Generic disturbance: a share of the load's torque on the motor that depends on its angle."""

from hannes.core.description import Description, waves
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.dynamics.generic_motor_torque import TRAVEL, over_angle


@kernel
def share_of_load(motor_angle, gear_ratio, load, c_0, c_1, c_2, c_3, c_4, c_5, c_6):
    """Torque on the rotor [N m]."""
    return load * over_angle(motor_angle / gear_ratio, c_0, c_1, c_2, c_3, c_4, c_5, c_6)


GENERIC = Description(
    Effect(
        name="generic_load_torque",
        meaning="The motor bears a share more or less of its load, by its angle. It describes, and "
        "names no cause.",
        equation="J w' += tl sum c_k cos(k pi th / (N travel))",
        source="Fourier's series",
        parameters=waves("1", 0.2),
        terms=(Term(share_of_load, writes=("motor_torque",), unit="N m"),),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="a share of the load's torque on the motor",
    value_unit="1",
    law=over_angle,
)
