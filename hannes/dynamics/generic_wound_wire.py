"""Generic disturbance: any error of the wire that the motor winds, over its angle.

The wire pulls back on the motor by the slope of that error, so that power is conserved.
"""

import math

from hannes.core.description import Description, waves_from_zero
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import cosines_from_zero
from hannes.dynamics.generic_motor_torque import TRAVEL

WAVE = math.pi / TRAVEL  # 1/rad, of the slowest cosine


@kernel
def error(angle, c_1, c_2, c_3, c_4, c_5, c_6):
    """Wire wound too much [m] at an angle of the output shaft [rad]: none at 0."""
    return cosines_from_zero(angle / TRAVEL, c_1, c_2, c_3, c_4, c_5, c_6)


@kernel
def slope(angle, c_1, c_2, c_3, c_4, c_5, c_6):
    """Its derivative by the angle [m/rad]."""
    first, second = math.sin(WAVE * angle), math.sin(2.0 * WAVE * angle)
    third, fourth = math.sin(3.0 * WAVE * angle), math.sin(4.0 * WAVE * angle)
    fifth, sixth = math.sin(5.0 * WAVE * angle), math.sin(6.0 * WAVE * angle)
    slow = c_1 * first + 2.0 * c_2 * second + 3.0 * c_3 * third
    return -WAVE * (slow + 4.0 * c_4 * fourth + 5.0 * c_5 * fifth + 6.0 * c_6 * sixth)


@kernel
def wound(motor_angle, gear_ratio, c_1, c_2, c_3, c_4, c_5, c_6):
    """Added to the leader's free length [m]."""
    return -error(motor_angle / gear_ratio, c_1, c_2, c_3, c_4, c_5, c_6)


@kernel
def pulling_back(motor_angle, gear_ratio, gear_pulley_radius, load, c_1, c_2, c_3, c_4, c_5, c_6):
    """Torque on the rotor [N m]; load: of the wire on the motor by the pulley's radius [N m]."""
    share = slope(motor_angle / gear_ratio, c_1, c_2, c_3, c_4, c_5, c_6) / gear_pulley_radius
    return -load * share


GENERIC = Description(
    Effect(
        name="generic_wound_wire",
        meaning="The motor winds wire unevenly over its angle. It describes, and names no cause.",
        equation="s_L += e, T_motor -= tl e' / r_p, e = sum c_k (cos(k pi th / (N travel)) - 1)",
        source="Fourier's series",
        parameters=waves_from_zero("m", 2e-3),
        terms=(
            Term(wound, writes=("slack",), unit="m"),
            Term(pulling_back, writes=("motor_torque",), unit="N m"),
        ),
    ),
    axis="the output shaft's angle",
    unit="rad",
    ends=(0.0, TRAVEL),
    value="wire wound too much",
    value_unit="m",
    law=error,
)
