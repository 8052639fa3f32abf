"""Penalty contact (paper eq. 3) with regularised tangential friction; it never pulls."""

from hannes.core.kernels.jit import kernel
from hannes.core.kernels.smooth_switches import smoothstep
from hannes.core.kernels.vector_math import soft_sign
from hannes.core.parameter import Parameter, group

PARAMETERS = group(
    "object",
    Parameter("stiffness", 38300.0, "N/m", (1, 1e7), "k of eq. 3, at each phalanx"),
    Parameter("damping", 184.0, "N s/m", (0, 1e5), "beta of eq. 3, at each phalanx"),
    Parameter("friction", 0.55, "1", (0, 3), "Coulomb coefficient against the phalanx"),
    Parameter("slip_speed", 5e-3, "m/s", (1e-6, 1), "width of the friction tanh"),
    Parameter("onset", 1e-4, "m", (1e-8, 1e-2), "penetration to full damping"),
    Parameter("x", 0.0146, "m", (-0.5, 0.5), "centre in the hand frame"),
    Parameter("y", -0.0469, "m", (-0.5, 0.5), "centre in the hand frame"),
    Parameter("z", 0.0, "m", (-0.5, 0.5), "centre in the hand frame"),
    Parameter("radius", 0.026, "m", (1e-4, 0.3), "sphere or cylinder; rounding of a prism's edges"),
    Parameter("half_x", 0.0, "m", (0, 0.3), "half of a prism's width"),
    Parameter("half_y", 0.0, "m", (0, 0.3), "half of a prism's height"),
    Parameter("turn", 0.0, "rad", (-3.2, 3.2), "of a prism about its axis, from x to y"),
    Parameter("tilt_x", 0.0, "rad", (-1.0, 1.0), "of the axis of cylinder or prism, from z to x"),
    Parameter("tilt_y", 0.0, "rad", (-1.0, 1.0), "of the axis of cylinder or prism, from z to y"),
)


@kernel
def normal_law(depth, rate, stiffness, damping, onset):
    """Normal force before it is clipped: k x + beta x' (eq. 3) [N]; depth [m], rate [m/s].

    The damping term grows over `onset`, so a touch begins without a jump.
    """
    return stiffness * max(depth, 0.0) + damping * rate * smoothstep(depth / onset)


@kernel
def tangential_law(normal_force, slip_speed, coefficient, width):
    """Friction in the contact plane, opposing `slip_speed` [m/s]: mu F_n tanh(v / v_s) [N]."""
    return coefficient * normal_force * soft_sign(slip_speed / width)


@kernel
def sensed(normal_force, drag, normal_x, normal_y):
    """Share of one contact in the dynamometer's reading [N].

    The sensing face is the object's side towards the fingertips; it feels what presses it
    towards the palm, along -x of the hand frame.
    """
    if normal_x <= 0.0:
        return 0.0
    return normal_force * normal_x + drag * normal_y
