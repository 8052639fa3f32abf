"""Generic disturbance: friction of motor and gear about one angle of each turn of the output."""

import math

import numpy as np

from hannes.core.description import Description
from hannes.core.effect import Effect, Term
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter

PLACES = tuple(float(each) for each in np.linspace(-math.pi, math.pi, 17)[:-1])  # rad
WIDTHS = 0.15, 0.5  # rad


@kernel
def over_turn(angle, torque, place, width):
    """Friction [N m] at an angle of the output shaft [rad]: a bell once a turn."""
    return torque * math.exp((math.cos(angle - place) - 1.0) / (width * width))


@kernel
def against(motor_angle, motor_speed, motor_friction_speed, gear_ratio, torque, place, width):
    """Added to what opposes the motor [N m]."""
    there = over_turn(motor_angle / gear_ratio, torque, place, width)
    return soft_sign(motor_speed / motor_friction_speed) * there


GENERIC = Description(
    Effect(
        name="generic_turn_friction",
        meaning="The output rubs at one angle of each turn. It describes, and names no cause.",
        equation="T_friction += torque exp((cos(th / N - place) - 1) / width^2) tanh(w / w_s)",
        source="von Mises (1918)",
        parameters=(
            Parameter("torque", 0.0, "N m", (-0.01, 0.01), "at its place", "choice", off=0.0),
            Parameter("place", 0.0, "rad", (-4.0, 4.0), "in a turn", "choice", tried=PLACES),
            Parameter("width", 0.15, "rad", (0.1, 1.0), "of it", "choice", tried=WIDTHS),
        ),
        terms=(Term(against, writes=("gear_friction",), unit="N m"),),
    ),
    axis="the output shaft's angle in a turn",
    unit="rad",
    ends=(-math.pi, math.pi),
    value="friction of motor and gear at one place",
    value_unit="N m",
    law=over_turn,
)
