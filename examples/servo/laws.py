"""Formulas of a servo that its equations call."""

import math

from hannes import kernel


@kernel
def sent(time, reference, window):
    """The command before a time [s], the one that comes next [rad], and its share.

    A step in which a command comes in has a part of both, so that a delay of any size shows.
    reference: times [s] and commands, shape (2, n)
    window: about a command [s]; 0 for none: sensors are read before a command is sent
    """
    begun = time - 0.5 * window
    low, high = -1, reference.shape[1]
    while high - low > 1:
        middle = (low + high) // 2
        if reference[0, middle] < begun:
            low = middle
        else:
            high = middle
    now = reference[1, max(low, 0)]
    if low < 0 or high == reference.shape[1] or reference[0, high] >= begun + window:
        return now, now, 0.0
    return now, reference[1, high], 1.0 - (reference[0, high] - begun) / window


@kernel
def asked(error, gain, limit):
    """Duty of a P controller for a position error [rad], clipped."""
    return min(max(gain * error, -limit), limit)


@kernel
def rubbing(motor_speed, level, onset_speed, viscous):
    """Coulomb friction that turns within an onset speed, and viscous friction [N m]."""
    return level * math.tanh(motor_speed / onset_speed) + viscous * motor_speed


@kernel
def weight(shaft_position, torque, angle):
    """Torque of gravity on the shaft [N m]: it hangs down where position + angle is 0."""
    return torque * math.sin(shaft_position + angle)
