"""Generic disturbance: commands arrive late, by a time that depends on speed."""

from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import placed

FASTEST = 30.0  # rad/s, of the output shaft


@kernel
def over_speed(speed, c_0, c_1, c_2):
    """Lag [s] at a speed of the output shaft [rad/s]."""
    x = placed(speed, -FASTEST, FASTEST)
    return c_0 + c_1 * x + c_2 * (1.5 * x * x - 0.5)


@kernel
def late(motor_speed, gear_ratio, c_0, c_1, c_2):
    """Shift of the time at which the reference is read [s]."""
    return -over_speed(motor_speed / gear_ratio, c_0, c_1, c_2)


GENERIC = Description(
    Effect(
        name="generic_command_lag",
        meaning="Commands reach the controller late, by speed. It describes, and names no cause.",
        equation="the reference used at t is that of t - sum c_k P_k(w / (N w_max))",
        source="Legendre's polynomials",
        parameters=coefficients("s", 0.03, 3),
        terms=(Term(late, writes=("reference_time",), unit="s"),),
    ),
    axis="the output shaft's speed",
    unit="rad/s",
    ends=(-FASTEST, FASTEST),
    value="the lag of the command",
    value_unit="s",
    law=over_speed,
)
