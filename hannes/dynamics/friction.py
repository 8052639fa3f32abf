"""Friction of joints and guides: equations 1 and 2 of the paper."""

import math

from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import exp_minus_one, soft_sign
from hannes.core.parameter import Parameter


@kernel
def stribeck(speed, breakaway, coulomb, breakaway_speed, viscous):
    """Friction opposing `speed`: breakaway peak + Coulomb + viscous (paper eq. 1 and 2).

    sqrt(2 e) (T_bf - T_cf) exp(-(w / (w_bf sqrt 2))^2) w / (w_bf sqrt 2)
    + T_cf tanh(w / (0.1 w_bf)) + f w

    `speed` w [rad/s or m/s], `breakaway` T_bf and `coulomb` T_cf [N m or N],
    `breakaway_speed` w_bf [rad/s or m/s], `viscous` f [N m s/rad or N s/m]; after
    Armstrong & Canudas de Wit (1995).
    """
    x = speed / breakaway_speed  # sqrt(2) times the argument above
    fade = 1.0 + exp_minus_one(-0.5 * x * x)
    peak = math.sqrt(math.e) * (breakaway - coulomb) * fade * x
    return peak + coulomb * soft_sign(10.0 * x) + viscous * speed


@kernel
def stribeck_slope(speed, breakaway, coulomb, breakaway_speed, viscous):
    """Derivative of `stribeck` by speed."""
    x = speed / breakaway_speed
    fade = 1.0 + exp_minus_one(-0.5 * x * x)
    peak = math.sqrt(math.e) * (breakaway - coulomb) * fade * (1.0 - x * x)
    level = soft_sign(10.0 * x)
    return (peak + 10.0 * coulomb * (1.0 - level * level)) / breakaway_speed + viscous


@kernel
def dry(speed, level, onset_speed):
    """Coulomb friction regularised over `onset_speed`: T tanh(w / w_s); T [N m], w [rad/s]."""
    return level * soft_sign(speed / onset_speed)


def friction_parameters(
    force: str, speed: str, values: tuple[float, float, float, float], source: str
) -> tuple[Parameter, ...]:
    """Declare one place's four friction parameters: T_bf, T_cf, w_bf, f in SI."""
    breakaway, coulomb, breakaway_speed, viscous = values
    per_speed = "N m s/rad" if force == "N m" else "N s/m"
    return (
        Parameter("breakaway_friction", breakaway, force, (0, 10), "peak before sliding", source),
        Parameter("coulomb_friction", coulomb, force, (0, 10), "level while sliding", source),
        Parameter("breakaway_speed", breakaway_speed, speed, (1e-5, 1e3), "of the peak", source),
        Parameter("viscous_friction", viscous, per_speed, (0, 1e4), "rise with speed", source),
    )
