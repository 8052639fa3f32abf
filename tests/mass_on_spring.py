"""The equations of a mass on a spring, pulled by a reference: a compiled plant of a few lines."""

import math

from hannes.control.reference import interpolate
from hannes.core.kernels.insertion import effects


def equations(t, y, dy, p, c, reference, memory, out):
    """Fill dy with the rates of place [m] and speed [m/s]."""
    push = interpolate(t, reference) + memory[0]
    push = effects(push)
    dy.place = y.speed
    dy.speed = push - p.stiffness * y.place - math.tanh(p.level * y.speed)
    out.force = push


def sample(t, y, dy, p, c, reference, memory, out):
    """Firmware that holds what it read of the place [m]."""
    memory[0] = -0.1 * y.place
