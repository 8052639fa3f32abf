"""The hand's equations of motion, stage by stage, as in section II of the paper.

This text is the model. `p.name`, `y.name`, `c.name` and `out.name` stand for slots of plain
arrays (parameters, states, channels, outputs; see variables.py); `assemble` fills in the
numbers, puts the calls of the chosen effects in place of each `channel = effects(channel)`, and
compiles the result. `print(hand.equations())` shows it. SI units; the motor at its own side.
It is long and stays one file: one text to read from motor to fingertip, and to compile as a whole.
"""

import math

from hannes.contact.leaning import nearest_place
from hannes.contact.penalty import normal_law, sensed, tangential_law
from hannes.contact.section import contact_place, signed_distance
from hannes.control.drive import drive_voltage
from hannes.control.encoder import quantised
from hannes.control.firmware_memory import (
    CURRENT_INTEGRAL,
    CURRENT_REFERENCE,
    DUTY,
    FILTERED_SPEED,
    LAST_ANGLE,
    LAST_CURRENT,
    POSITION_INTEGRAL,
    PROBED_CURRENT,
    PROBED_SHAFT,
    READING_AGE,
)
from hannes.control.pid import integral_rate, pid, saturated
from hannes.control.reference import interpolate
from hannes.control.sensor_noise import coloured
from hannes.core.kernels.insertion import effects
from hannes.core.kernels.vector_math import direction
from hannes.dynamics.carts import cart_rate
from hannes.dynamics.finger import gravity_torque, kinetic_energy, solve_inertia
from hannes.dynamics.friction import dry, stribeck
from hannes.dynamics.joints import spring_torque, stop_torque
from hannes.dynamics.motor import current_rate, speed_rate
from hannes.dynamics.wires import follower_stretch, leader_stretch, tension


def equations(t, y, dy, p, c, reference, memory, out):
    """Fill dy with the rates of all states."""
    for i in range(dy.size):
        dy[i] = 0.0  # of effects in a stage that is left out
    target = position_reference(t, y, dy, p, c, reference, out)
    position, current = sense(t, y, dy, p, c, memory, out)
    duty = control(t, y, dy, p, c, memory, target, position, current, out)
    torque_constant = drive(t, y, dy, p, c, duty, out)
    kinematics(y, p, c)
    load = leader(t, y, dy, p, c, out)
    gear(t, y, dy, p, c, torque_constant, load, out)
    carts(t, y, dy, p, c, out)
    joints(t, y, dy, p, c, out)
    if p.object_present > 0.5:
        contact(t, y, dy, p, c, out)
    inertia(t, y, dy, p, c, out)


def position_reference(t, y, dy, p, c, reference, out):
    """Where the output shaft should be [rad]."""
    reference_time = t
    reference_time = effects(reference_time)
    target = interpolate(reference_time, reference)
    out.reference = target
    return target


def probe(t, y, dy, p, c, out):
    """What encoder and current sensor are put to: shaft [rad, output side] and current [A]."""
    shaft_position, sensed_current = y.motor_angle / p.gear_ratio, y.motor_current
    shaft_position, sensed_current = effects(shaft_position, sensed_current)
    return shaft_position, sensed_current


def sense(t, y, dy, p, c, memory, out):
    """What the controller sees: encoder [rad, output shaft] and current sensor [A]."""
    shaft_position, sensed_current = probe(t, y, dy, p, c, out)
    held_position, held_current = memory[PROBED_SHAFT], memory[PROBED_CURRENT]
    delayed_position, delayed_current = shaft_position, sensed_current
    delayed_position, delayed_current = effects(delayed_position, delayed_current)
    measured_position, measured_current = delayed_position, delayed_current
    measured_position, measured_current = effects(measured_position, measured_current)
    if p.controller_current_noise > 0.0 and p.controller_sampled > 0.5:
        seed, tick = int(p.controller_noise_seed), round(t / p.controller_period)
        noise = coloured(seed, tick, p.controller_noise_bandwidth, p.controller_period)
        measured_current += p.controller_current_noise * noise
    out.position = measured_position
    out.current = measured_current
    return measured_position, measured_current


def control(t, y, dy, p, c, memory, target, position, current, out):
    """Two nested PIDs: position -> current reference -> duty; firmware holds its last duty."""
    dy.position_integral, dy.position_lag = 0.0, 0.0
    dy.current_integral, dy.current_lag = 0.0, 0.0
    if p.controller_sampled > 0.5:
        out.duty = memory[DUTY]
        out.current_reference = memory[CURRENT_REFERENCE]
        return memory[DUTY]
    angle = position * p.gear_ratio
    speed = (angle - y.position_lag) / p.position_pid_filter
    position_error = target * p.gear_ratio - angle
    position_error = effects(position_error)
    wanted = pid(
        position_error,
        y.position_integral,
        speed,
        p.position_pid_proportional,
        p.position_pid_derivative,
    )
    asked = saturated(wanted, p.position_pid_limit)
    dy.position_lag = speed
    dy.position_integral = integral_rate(
        position_error, wanted, asked, p.position_pid_proportional, p.position_pid_integral
    )
    rise = (current - y.current_lag) / p.current_pid_filter
    error = asked - current
    wanted = pid(
        error, y.current_integral, rise, p.current_pid_proportional, p.current_pid_derivative
    )
    given = saturated(wanted, p.supply_voltage)
    dy.current_lag = rise
    dy.current_integral = integral_rate(
        error, wanted, given, p.current_pid_proportional, p.current_pid_integral
    )
    out.duty = given / p.supply_voltage
    out.current_reference = asked
    return given / p.supply_voltage


def sample(t, y, dy, p, c, reference, memory, out):
    """One tick of the firmware: read, filter, two PIDs, and hold the duty until the next.

    `memory` is what it keeps from tick to tick (firmware_memory.py). The state `y` is of the moment
    of its readings: as old as the tick before left in `memory`.
    """
    target = position_reference(t, y, dy, p, c, reference, out)
    reading_age = 0.0
    reading_age = effects(reading_age)
    memory[READING_AGE] = reading_age
    memory[PROBED_SHAFT], memory[PROBED_CURRENT] = probe(t, y, dy, p, c, out)
    position, current = sense(t, y, dy, p, c, memory, out)
    angle = quantised(position, p.encoder_bits) * p.gear_ratio
    period = p.controller_period
    if p.controller_current_step > 0.0:
        current = p.controller_current_step * round(current / p.controller_current_step)
    memory[FILTERED_SPEED] += p.controller_speed_weight * (
        (angle - memory[LAST_ANGLE]) / period - memory[FILTERED_SPEED]
    )
    rise = (current - memory[LAST_CURRENT]) / period
    position_error = target * p.gear_ratio - angle
    position_error = effects(position_error)
    wanted = pid(
        position_error,
        memory[POSITION_INTEGRAL],
        memory[FILTERED_SPEED],
        p.position_pid_proportional,
        p.position_pid_derivative,
    )
    asked = min(max(wanted, -p.position_pid_limit), p.position_pid_limit)
    memory[POSITION_INTEGRAL] += period * integral_rate(
        position_error, wanted, asked, p.position_pid_proportional, p.position_pid_integral
    )
    error = asked - current
    wanted = pid(
        error, memory[CURRENT_INTEGRAL], rise, p.current_pid_proportional, p.current_pid_derivative
    )
    given = min(max(wanted, -p.supply_voltage), p.supply_voltage)
    memory[CURRENT_INTEGRAL] += period * integral_rate(
        error, wanted, given, p.current_pid_proportional, p.current_pid_integral
    )
    memory[LAST_ANGLE], memory[LAST_CURRENT] = angle, current
    memory[CURRENT_REFERENCE] = asked
    memory[DUTY] = given / p.supply_voltage


def drive(t, y, dy, p, c, duty, out):
    """PWM drive and winding: L di/dt = V - R i - k_e w; returns k_t [N m/A]."""
    current, speed = y.motor_current, y.motor_speed
    duty = effects(duty)
    supply = p.supply_voltage
    supply = effects(supply)
    voltage = drive_voltage(duty, supply)
    voltage = effects(voltage)
    resistance, torque_constant = p.motor_resistance, p.motor_torque_constant
    resistance, torque_constant = effects(resistance, torque_constant)
    dy.motor_current = current_rate(
        voltage, current, speed, resistance, torque_constant, p.motor_inductance
    )
    out.supply = supply
    out.power_electrical = voltage * current
    out.power_copper = resistance * current**2
    out.power_inductance = p.motor_inductance * current * dy.motor_current
    return torque_constant


def kinematics(y, p, c):
    """Directions of the links, and flexor wire taken up: r_1 (q_1 - q_1rest) + r_2 (...).

    The size of an array is a number that the compiler does not know: loops over it stay loops,
    worked on several elements at a time.
    """
    for joint in range(10):
        c.lane_angle[joint] = y.joint_angle[joint]
    for joint in range(p.rest.size):
        c.bend_cosine[joint], c.bend_sine[joint] = direction(c.lane_angle[joint])
    for f in range(5):
        mcp, pip = 2 * f, 2 * f + 1
        cosine, sine = c.bend_cosine[mcp], c.bend_sine[mcp]
        c.cosine[mcp], c.sine[mcp] = cosine, sine
        c.cosine[pip] = cosine * c.bend_cosine[pip] - sine * c.bend_sine[pip]
        c.sine[pip] = sine * c.bend_cosine[pip] + cosine * c.bend_sine[pip]
    excursions(y, p, c)


def excursions(y, p, c):
    """Flexor wire taken up by each finger [m], and its rate [m/s]."""
    for joint in range(10):
        c.lane_speed[joint] = y.joint_speed[joint]
    for f in range(5):
        mcp, pip = 2 * f, 2 * f + 1
        c.excursion[f] = p.joint_moment_arm[mcp] * (y.joint_angle[mcp] - p.rest[mcp])
        c.excursion[f] += p.joint_moment_arm[pip] * (y.joint_angle[pip] - p.rest[pip])
        c.excursion_rate[f] = p.joint_moment_arm[mcp] * y.joint_speed[mcp]
        c.excursion_rate[f] += p.joint_moment_arm[pip] * y.joint_speed[pip]


def leader(t, y, dy, p, c, out):
    """Leader wire around both cart pulleys to the thumb; returns its load on the motor [N m]."""
    slack, leader_compliance = 0.0, 1.0 / p.leader_stiffness
    slack, leader_compliance = effects(slack, leader_compliance)
    arm = p.gear_pulley_radius / p.gear_ratio
    stretch = leader_stretch(
        arm * y.motor_angle, y.cart_position[0], y.cart_position[1], c.excursion[4], slack
    )
    rate = leader_stretch(
        arm * y.motor_speed, y.cart_speed[0], y.cart_speed[1], c.excursion_rate[4], 0.0
    )
    stiffness = 1.0 / leader_compliance
    c.leader_stretch, c.leader_rate, c.leader_stiffness = stretch, rate, stiffness
    leader_tension = tension(stretch, rate, stiffness, p.leader_damping, p.wires_onset)
    leader_tension = effects(leader_tension)
    pull_a, pull_b, pull_thumb = leader_tension, leader_tension, leader_tension
    rate_a, rate_b, rate_thumb = y.cart_speed[0], y.cart_speed[1], c.excursion_rate[4]
    pull_a, pull_b, pull_thumb = effects(pull_a, pull_b, pull_thumb)
    c.leader_pull[0], c.leader_pull[1], c.tendon_tension[4] = pull_a, pull_b, pull_thumb
    out.leader_tension = leader_tension
    out.leader_stretch = stretch
    out.power_wire_elastic = stiffness * max(stretch, 0.0) * rate
    out.power_wire_damping = (leader_tension - stiffness * max(stretch, 0.0)) * rate
    out.power_wire_friction = (
        2.0 * (leader_tension - pull_a) * rate_a
        + 2.0 * (leader_tension - pull_b) * rate_b
        + (leader_tension - pull_thumb) * rate_thumb
    )
    return arm * leader_tension


def gear(t, y, dy, p, c, torque_constant, load, out):
    """Rotor and reducer: J dw/dt = k_t i - friction - load, with load = r_p T_L / N."""
    speed = y.motor_speed
    gear_friction = dry(speed, p.motor_dry_friction, p.motor_friction_speed)
    gear_friction += p.motor_viscous_friction * speed
    motor_torque = 0.0
    gear_friction, motor_torque = effects(gear_friction, motor_torque)
    dy.motor_angle = speed
    dy.motor_speed = speed_rate(
        torque_constant, y.motor_current, gear_friction - motor_torque, load, p.motor_inertia
    )
    out.power_gear_friction = gear_friction * speed
    out.power_motor_torque = -motor_torque * speed


def carts(t, y, dy, p, c, out):
    """Carts A (index, middle) and B (ring, little): m x'' = 2 T_L - 2 T_F - F(x') (eq. 2)."""
    follower_compliance = 1.0 / p.follower_stiffness
    follower_compliance = effects(follower_compliance)
    for cart in range(2):
        c.cart_friction[cart] = stribeck(
            y.cart_speed[cart],
            p.cart_breakaway_friction,
            p.cart_coulomb_friction,
            p.cart_breakaway_speed,
            p.cart_viscous_friction,
        )
    for cart in range(2):
        c.follower_slip[cart] = 0.5 * (c.excursion_rate[2 * cart] - c.excursion_rate[2 * cart + 1])
        c.follower_loss[cart] = 0.0
    c.cart_friction, c.follower_loss = effects(c.cart_friction, c.follower_loss)
    for cart in range(2):
        first, second = 2 * cart, 2 * cart + 1
        stiffness = 1.0 / follower_compliance
        stretch = follower_stretch(y.cart_position[cart], c.excursion[first], c.excursion[second])
        rate = follower_stretch(
            y.cart_speed[cart], c.excursion_rate[first], c.excursion_rate[second]
        )
        pull = tension(stretch, rate, stiffness, p.follower_damping, p.wires_onset)
        c.follower_stretch[cart], c.follower_rate[cart] = stretch, rate
        c.follower_stiffness = stiffness
        c.tendon_tension[first] = pull - pull * c.follower_loss[cart]
        c.tendon_tension[second] = pull + pull * c.follower_loss[cart]
        dy.cart_position[cart] = y.cart_speed[cart]
        dy.cart_speed[cart] = cart_rate(
            c.leader_pull[cart], pull, c.cart_friction[cart], p.cart_mass
        )
        out.follower_tension[cart] = pull
        out.power_cart_friction += c.cart_friction[cart] * y.cart_speed[cart]
        out.power_wire_elastic += stiffness * max(stretch, 0.0) * rate
        out.power_wire_damping += (pull - stiffness * max(stretch, 0.0)) * rate
        out.power_wire_friction += 2.0 * pull * c.follower_loss[cart] * c.follower_slip[cart]
    c.tendon_tension = effects(c.tendon_tension)


def joints(t, y, dy, p, c, out):
    """Torques on MCP and PIP: flexor wire, re-opening spring, friction (eq. 1), stops, gravity."""
    for joint in range(p.rest.size):
        c.spring_torque[joint] = spring_torque(
            c.lane_angle[joint],
            p.rest[joint],
            p.joint_spring_stiffness[joint],
            p.joint_spring_preload[joint],
        )
        c.joint_friction[joint] = stribeck(
            c.lane_speed[joint],
            p.joint_breakaway_friction[joint],
            p.joint_coulomb_friction[joint],
            p.joint_breakaway_speed[joint],
            p.joint_viscous_friction[joint],
        )
        c.stop_torque[joint] = stop_torque(
            c.lane_angle[joint],
            c.lane_speed[joint],
            p.rest[joint],
            p.end[joint],
            p.joint_spring_preload[joint],
            p.joint_stop_stiffness[joint],
            p.joint_stop_damping[joint],
            p.joint_stop_onset[joint],
        )
    c.spring_torque, c.joint_friction = effects(c.spring_torque, c.joint_friction)
    for joint in range(10):
        out.power_spring += c.spring_torque[joint] * y.joint_speed[joint]
        out.power_joint_friction += c.joint_friction[joint] * y.joint_speed[joint]
        out.power_stop -= c.stop_torque[joint] * y.joint_speed[joint]
        flexor = p.joint_moment_arm[joint] * c.tendon_tension[joint // 2]
        opening = c.spring_torque[joint] + c.joint_friction[joint]
        c.joint_torque[joint] = flexor + c.stop_torque[joint] - opening
    if p.gravity_x != 0.0 or p.gravity_y != 0.0:
        gravity(t, y, p, c, out)
    c.joint_torque = effects(c.joint_torque)


def gravity(t, y, p, c, out):
    """Weight of the links."""
    for f in range(5):
        mcp, pip = 2 * f, 2 * f + 1
        torque_1, torque_2 = gravity_torque(
            y.joint_angle[mcp],
            y.joint_angle[pip],
            p.gravity_x,
            p.gravity_y * p.facing[f],
            p.link_length[mcp],
            p.link_length[pip],
            p.link_mass[mcp],
            p.link_mass[pip],
        )
        c.joint_torque[mcp] += torque_1
        c.joint_torque[pip] += torque_2
        out.power_gravity -= torque_1 * y.joint_speed[mcp] + torque_2 * y.joint_speed[pip]


def contact(t, y, dy, p, c, out):
    """Every phalanx against the object's section in its plane: eq. 3 and sliding friction."""
    object_x, object_y, object_angle = p.object_x, p.object_y, 0.0
    object_x, object_y, object_angle = effects(object_x, object_y, object_angle)
    for f in range(5):
        place_finger(p, c, f, object_x, object_y)
    if p.object_flat > 1.5:
        cosine, sine = math.cos(object_angle), math.sin(object_angle)
        for phalanx in range(10):
            touch_leaning(p, c, phalanx, cosine, sine)
    elif p.object_flat > 0.5:
        for phalanx in range(10):
            touch_flat(p, c, phalanx)
    else:
        for phalanx in range(p.link_length.size):
            touch_round(p, c, phalanx)
    for phalanx in range(p.link_length.size):
        levers(p, c, phalanx)
    press(t, y, dy, p, c, out)


def place_finger(p, c, f, object_x, object_y):
    """Joints of a finger's phalanges and centre of the object in the finger's plane."""
    mcp, pip = 2 * f, 2 * f + 1
    length = p.link_length[mcp]
    c.start_x[mcp], c.start_y[mcp] = 0.0, 0.0
    c.start_x[pip], c.start_y[pip] = length * c.cosine[mcp], -length * c.sine[mcp]
    centre_x, centre_y = object_x - p.mount_x[f], p.facing[f] * (object_y - p.mount_y[f])
    c.centre_x[mcp], c.centre_x[pip] = centre_x, centre_x
    c.centre_y[mcp], c.centre_y[pip] = centre_y, centre_y


def touch_round(p, c, phalanx):
    """Nearest place, normal and depth of one phalanx (capsule) against a circle."""
    away_x = c.start_x[phalanx] - c.centre_x[phalanx]
    away_y = c.start_y[phalanx] - c.centre_y[phalanx]
    place = away_y * c.sine[phalanx] - away_x * c.cosine[phalanx]
    place = min(max(place, 0.0), p.link_length[phalanx])
    away_x += place * c.cosine[phalanx]
    away_y -= place * c.sine[phalanx]
    distance = math.sqrt(away_x * away_x + away_y * away_y) + 1e-30
    c.place[phalanx] = place
    c.normal_x[phalanx] = away_x / distance
    c.normal_y[phalanx] = away_y / distance
    c.penetration[phalanx] = p.reach[phalanx] - distance


def touch_flat(p, c, phalanx):
    """The same against a section with flat sides."""
    f = phalanx // 2
    half_x, half_y = p.section_half_x[f], p.section_half_y[f]
    along_x, along_y = c.cosine[phalanx], -c.sine[phalanx]
    away_x = c.start_x[phalanx] - c.centre_x[phalanx]
    away_y = c.start_y[phalanx] - c.centre_y[phalanx]
    place = contact_place(away_x, away_y, along_x, along_y, p.link_length[phalanx], half_x, half_y)
    gap, normal_x, normal_y = signed_distance(
        away_x + place * along_x, away_y + place * along_y, half_x, half_y
    )
    c.penetration[phalanx] = p.reach[phalanx] - gap
    c.place[phalanx], c.normal_x[phalanx], c.normal_y[phalanx] = place, normal_x, normal_y


def touch_leaning(p, c, phalanx, cosine, sine):
    """The same against a section of an object that is tilted or turned."""
    f = phalanx // 2
    facing, aside_x, aside_y = p.facing[f], p.section_aside_x[f], p.section_aside_y[f]
    start_x = c.start_x[phalanx] - c.centre_x[phalanx] - (cosine * aside_x - sine * aside_y)
    start_y = c.start_y[phalanx] - c.centre_y[phalanx]
    start_y -= facing * (sine * aside_x + cosine * aside_y)
    section = (
        p.section_half_x[f],
        p.section_half_y[f],
        p.reach[phalanx] - p.phalanx_radius[phalanx],
        cosine * p.frame_xx - sine * p.frame_yx,
        cosine * p.frame_xy - sine * p.frame_yy,
        facing * (sine * p.frame_xx + cosine * p.frame_yx),
        facing * (sine * p.frame_xy + cosine * p.frame_yy),
    )
    along_x, along_y = c.cosine[phalanx], -c.sine[phalanx]
    place, gap, normal_x, normal_y = nearest_place(
        start_x, start_y, along_x, along_y, p.link_length[phalanx], section
    )
    c.penetration[phalanx] = p.phalanx_radius[phalanx] - gap
    c.place[phalanx], c.normal_x[phalanx], c.normal_y[phalanx] = place, normal_x, normal_y


def levers(p, c, phalanx):
    """Lever arms of one phalanx's contact forces about its finger's joints."""
    normal_x, normal_y = c.normal_x[phalanx], c.normal_y[phalanx]
    from_x = c.place[phalanx] * c.cosine[phalanx] - p.phalanx_radius[phalanx] * normal_x
    from_y = -c.place[phalanx] * c.sine[phalanx] - p.phalanx_radius[phalanx] * normal_y
    surface_x, surface_y = c.start_x[phalanx] + from_x, c.start_y[phalanx] + from_y
    c.normal_arm_mcp[phalanx] = normal_x * surface_y - normal_y * surface_x
    c.slip_arm_mcp[phalanx] = -normal_y * surface_y - normal_x * surface_x
    c.normal_arm_pip[phalanx] = p.distal[phalanx] * (normal_x * from_y - normal_y * from_x)
    c.slip_arm_pip[phalanx] = -p.distal[phalanx] * (normal_y * from_y + normal_x * from_x)


def press(t, y, dy, p, c, out):
    """Forces of all contacts, given their depths and lever arms."""
    for f in range(5):
        slide(y, c, 2 * f, y.joint_speed[2 * f], y.joint_speed[2 * f + 1])
        slide(y, c, 2 * f + 1, y.joint_speed[2 * f], y.joint_speed[2 * f + 1])
    c.penetration_rate, c.slip_speed = effects(c.penetration_rate, c.slip_speed)
    for phalanx in range(p.link_length.size):
        c.normal_force[phalanx] = normal_law(
            c.penetration[phalanx],
            c.penetration_rate[phalanx],
            p.object_stiffness,
            p.object_damping,
            p.object_onset,
        )
    c.normal_force = effects(c.normal_force)
    touching = 0
    for phalanx in range(p.link_length.size):
        c.normal_force[phalanx] = max(0.0, c.normal_force[phalanx])
        touching += c.normal_force[phalanx] > 0.0
        c.drag[phalanx], c.held_drag[phalanx] = 0.0, 0.0
    c.held_drag = effects(c.held_drag)
    if touching > 0:
        push(p, c, out)
    palm_force, object_power = 0.0, 0.0
    palm_force, object_power = effects(palm_force, object_power)
    out.palm_force = palm_force
    out.power_object = object_power
    sense_forces(t, y, dy, p, c, touching, out)


def slide(y, c, phalanx, mcp_speed, pip_speed):
    """Rate of depth and speed of slip of one phalanx."""
    c.penetration_rate[phalanx] = -(
        c.normal_arm_mcp[phalanx] * mcp_speed + c.normal_arm_pip[phalanx] * pip_speed
    )
    c.slip_speed[phalanx] = (
        c.slip_arm_mcp[phalanx] * mcp_speed + c.slip_arm_pip[phalanx] * pip_speed
    )


def push(p, c, out):
    """Hand the contact forces to the joints: J^T F."""
    for phalanx in range(p.link_length.size):
        normal = c.normal_force[phalanx]
        drag = tangential_law(normal, c.slip_speed[phalanx], p.object_friction, p.object_slip_speed)
        drag += c.held_drag[phalanx]
        c.drag[phalanx] = drag
        c.torque_mcp[phalanx] = normal * c.normal_arm_mcp[phalanx] - drag * c.slip_arm_mcp[phalanx]
        c.torque_pip[phalanx] = normal * c.normal_arm_pip[phalanx] - drag * c.slip_arm_pip[phalanx]
    for f in range(5):
        mcp, pip = 2 * f, 2 * f + 1
        c.joint_torque[mcp] += c.torque_mcp[mcp] + c.torque_mcp[pip]
        c.joint_torque[pip] += c.torque_pip[mcp] + c.torque_pip[pip]
    for phalanx in range(10):
        normal, drag = c.normal_force[phalanx], c.drag[phalanx]
        out.phalanx_force[phalanx] = normal
        out.power_contact_normal += normal * c.penetration_rate[phalanx]
        out.power_contact_tangential += drag * c.slip_speed[phalanx]


def sense_forces(t, y, dy, p, c, touching, out):
    """Forces that sensors log: of all fingers together, and of the dynamometer's face."""
    for f in range(5):
        c.logged_force[f], c.logged_sensor[f] = 0.0, 0.0
    if touching > 0:
        for phalanx in range(10):
            normal, drag = c.normal_force[phalanx], c.drag[phalanx]
            c.logged_force[phalanx // 2] += normal
            c.logged_sensor[phalanx // 2] += sensed(
                normal, drag, c.normal_x[phalanx], c.normal_y[phalanx]
            )
    c.logged_force, c.logged_sensor = effects(c.logged_force, c.logged_sensor)
    out.force = c.logged_force.sum()
    out.sensor = c.logged_sensor.sum()


def inertia(t, y, dy, p, c, out):
    """Solve M(q) q'' + c(q, q') = torque for each finger."""
    for f in range(5):
        mcp, pip = 2 * f, 2 * f + 1
        first, second = solve_inertia(
            c.joint_torque[mcp],
            c.joint_torque[pip],
            c.bend_cosine[pip],
            c.bend_sine[pip],
            y.joint_speed[mcp],
            y.joint_speed[pip],
            p.link_length[mcp],
            p.link_length[pip],
            p.link_mass[mcp],
            p.link_mass[pip],
        )
        dy.joint_angle[mcp], dy.joint_angle[pip] = y.joint_speed[mcp], y.joint_speed[pip]
        dy.joint_speed[mcp], dy.joint_speed[pip] = first, second
        out.energy_kinetic += kinetic_energy(
            y.joint_angle[pip],
            y.joint_speed[mcp],
            y.joint_speed[pip],
            p.link_length[mcp],
            p.link_length[pip],
            p.link_mass[mcp],
            p.link_mass[pip],
        )
    out.energy_kinetic += 0.5 * p.motor_inertia * y.motor_speed**2
    out.energy_kinetic += 0.5 * p.cart_mass * (y.cart_speed[0] ** 2 + y.cart_speed[1] ** 2)
