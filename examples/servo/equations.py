"""A geared position servo, stage by stage: what hannes compiles, with effects where they join.

`equations` fills `dy` with the rates of the states. A stage reads parameters as `p.motor_inertia`
and states as `y.motor_angle`, and fills outputs as `out.duty`. Where a line reads
`duty = open_to_effects(duty)`, effects add to the duty; their kernels may read what the stage has
by then, if servo.py lists it. Motor and friction are on the motor's side of the gear.
`memory`: the step of integration [s]; 0 where outputs are read.
"""

from laws import asked, rubbing, sent, weight

from hannes import open_to_effects


def equations(t, y, dy, p, c, reference, memory, out):
    """Fill dy with the rates of the motor's angle [rad] and speed [rad/s]."""
    target, coming, share = commanded(t, y, dy, p, c, reference, memory, out)
    shaft_position = shaft(t, y, dy, p, c, reference, out)
    drive_torque = drive(t, y, dy, p, c, target, coming, share, shaft_position, out)
    gear(t, y, dy, p, c, reference, shaft_position, drive_torque, out)


def commanded(t, y, dy, p, c, reference, memory, out):
    """Where the shaft should be [rad], where next, and the share of that in this step."""
    reference_time = t
    reference_time = open_to_effects(reference_time)
    target, coming, share = sent(reference_time, reference, memory[0])
    out.reference = target
    command = (1.0 - share) * target + share * coming
    first_command = reference[1, 0]
    aside = 0.0
    aside = open_to_effects(aside)
    return target + aside, coming + aside, share


def shaft(t, y, dy, p, c, reference, out):
    """Where the shaft is [rad]; its sensor sits on it."""
    first_command = reference[1, 0]
    shaft_position = y.motor_angle / p.gear_ratio
    shaft_position = open_to_effects(shaft_position)
    out.position = shaft_position
    return shaft_position


def drive(t, y, dy, p, c, target, coming, share, shaft_position, out):
    """P control on position, a clipped duty, a DC motor without inductance: torque [N m]."""
    duty = (1.0 - share) * asked(target - shaft_position, p.control_gain, p.control_limit)
    duty += share * asked(coming - shaft_position, p.control_gain, p.control_limit)
    out.duty = duty
    duty = open_to_effects(duty)
    supply = p.supply_voltage
    resistance = p.motor_resistance
    torque_constant = p.motor_torque_constant
    resistance, torque_constant = open_to_effects(resistance, torque_constant)
    back_emf = torque_constant * y.motor_speed
    supply = open_to_effects(supply)
    current = (duty * supply - back_emf) / resistance
    out.current = current
    return torque_constant * current


def gear(t, y, dy, p, c, reference, shaft_position, drive_torque, out):
    """Gear, friction and gravity on the rotor: J w' = drive_torque - load - friction."""
    first_command = reference[1, 0]
    motor_speed = y.motor_speed
    load = weight(shaft_position, p.gravity_torque, p.gravity_angle) / p.gear_ratio
    load = open_to_effects(load)
    gear_friction = rubbing(
        motor_speed, p.motor_dry_friction, p.motor_friction_speed, p.motor_viscous_friction
    )
    motor_torque = 0.0
    gear_friction, motor_torque = open_to_effects(gear_friction, motor_torque)
    dy.motor_angle = motor_speed
    dy.motor_speed = (drive_torque + motor_torque - load - gear_friction) / p.motor_inertia
