"""A motor-driven axis, stage by stage: the EMPS machine as its authors publish it.

The same conventions as the hand's equations.py. The drive is an ideal force on the moving mass;
friction comes from the hand's own kernels. `memory`: volts of the drive, the last two positions,
volts that are added behind the controller's limit.
"""

from hannes.control.cascade import cascade, mean_difference
from hannes.control.reference import interpolate
from hannes.core.kernels.insertion import effects
from hannes.dynamics.friction import dry


def equations(t, y, dy, p, c, reference, memory, out):
    """Fill dy with the rates of position [m] and speed [m/s]."""
    out.reference = position_reference(t, y, dy, p, c, reference, out)
    out.position = sense(t, y, dy, p, c, out)
    force = drive(t, y, dy, p, c, memory, out)
    gear(t, y, dy, p, c, force, out)


def position_reference(t, y, dy, p, c, reference, out):
    """Where the axis should be [m]."""
    reference_time = t
    reference_time = effects(reference_time)
    return interpolate(reference_time, reference)


def sense(t, y, dy, p, c, out):
    """What the controller sees of the position [m]."""
    measured_position = y.axis_position
    measured_position = effects(measured_position)
    return measured_position


def sample(t, y, dy, p, c, reference, memory, out):
    """One sample of the controller: u = k_v (k_p (target - q) - q') and the added volts."""
    target = position_reference(t, y, dy, p, c, reference, out)
    position = sense(t, y, dy, p, c, out)
    speed = mean_difference(position, memory[1], memory[2], p.cascade_period)
    asked = cascade(
        target, position, speed, p.cascade_position_gain, p.cascade_speed_gain, p.cascade_limit
    )
    memory[2], memory[1] = memory[1], position
    memory[0] = asked + memory[3]


def drive(t, y, dy, p, c, memory, out):
    """Ideal amplifier and motor: force [N] = gain times volts, held from sample to sample."""
    voltage = memory[0]
    voltage = effects(voltage)
    out.drive = memory[0]
    return p.axis_force_gain * voltage


def gear(t, y, dy, p, c, force, out):
    """Screw and load: M q'' = force - friction - offset; the screw carries `load` [N]."""
    motor_speed = y.motor_speed
    load = force
    gear_friction = dry(motor_speed, p.motor_dry_friction, p.motor_friction_speed)
    gear_friction += p.motor_viscous_friction * motor_speed
    motor_torque = 0.0
    gear_friction, motor_torque = effects(gear_friction, motor_torque)
    dy.axis_position = motor_speed
    dy.motor_speed = (load + motor_torque - gear_friction - p.axis_offset) / p.axis_mass
    out.friction = gear_friction
