"""A finger on a fixed object, stage by stage: its recorded angle presses, a sensor logs the force.

The same conventions as the hand's equations.py. Angle and force are the hand's own counts, as it
logs them. `memory`: angle of the first sample, its reading, speed of closing [100 counts/s].
"""

from hannes.control.reference import interpolate
from hannes.core.kernels.insertion import effects
from hannes.plants.finger.elastic import pressed


def equations(t, y, dy, p, c, reference, memory, out):
    """Fill dy with the rates of whatever states the effects bring; the base has none."""
    angle = closed(t, y, dy, p, c, reference, out)
    rested = pressed(memory[0], p.contact_stiffness, p.contact_angle, p.contact_exponent)
    force = contact(t, y, dy, p, c, angle, rested, memory[2], out)
    sensor(t, y, dy, p, c, force, memory[1], out)


def closed(t, y, dy, p, c, reference, out):
    """Angle of the actuator [counts], open at 1000."""
    reading_time = t
    reading_time = effects(reading_time)
    out.angle = interpolate(reading_time, reference)
    return interpolate(reading_time, reference)


def contact(t, y, dy, p, c, angle, rested, closing_speed, out):
    """Force of the object on the finger, F = k max(a_c - angle / 100, 0)^n, never pulling.

    `rested` is the force at which the recording starts.
    """
    elastic = pressed(angle, p.contact_stiffness, p.contact_angle, p.contact_exponent)
    contact_force = elastic
    contact_force = effects(contact_force)
    out.contact_force = max(contact_force, 0.0)
    return max(contact_force, 0.0)


def sensor(t, y, dy, p, c, force, first_reading, out):
    """Force as the hand logs it [counts]."""
    logged_force = force
    logged_force = effects(logged_force)
    out.force = logged_force
