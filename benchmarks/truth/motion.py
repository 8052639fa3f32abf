"""Rates of the whole hand's state (SI, motor side), from the motor out to the fingertips.

State: 0-9 joint angles (2 finger + joint), 10-19 their speeds, 20-21 carts, 22-23 their speeds,
24 motor angle, 25 motor speed, 26 current, 27 position integral, 28 speed filter's lag, 29 volts of
the current integral. The last three rest where the controller is sampled.
"""

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.controller import continuous
from benchmarks.truth.finger import finger
from benchmarks.truth.laws import drive_friction, friction, one_sided, spring_and_stops

SIZE = 30


@compiled
def excursion(h, y, f):
    """Flexor taken up by finger f (m) and its rate (m/s)."""
    r1, r2 = h.mcp_moment_arm, h.pip_moment_arm
    taken = r1 * (y[2 * f] - h.fingers_mcp_rest[f]) + r2 * (y[2 * f + 1] - h.fingers_pip_rest[f])
    return taken, r1 * y[10 + 2 * f] + r2 * y[11 + 2 * f]


@compiled
def follower_tension(h, y, c):
    """Tension (N) of cart c's follower wire: index and middle (0), ring and little (1)."""
    one, one_rate = excursion(h, y, 2 * c)
    two, two_rate = excursion(h, y, 2 * c + 1)
    stretch, rate = 2.0 * y[20 + c] - one - two, 2.0 * y[22 + c] - one_rate - two_rate
    return one_sided(stretch, rate, h.follower_stiffness, h.follower_damping, h.wires_onset)


@compiled
def leader_tension(h, y):
    """Tension (N) of the leader wire, from the pulley over both carts to the thumb."""
    thumb, thumb_rate = excursion(h, y, 4)
    arm = h.gear_pulley_radius / h.gear_ratio
    stretch = arm * y[24] - h.slack - 2.0 * (y[20] + y[21]) - thumb
    rate = arm * y[25] - 2.0 * (y[22] + y[23]) - thumb_rate
    return one_sided(stretch, rate, h.leader_stiffness, h.leader_damping, h.wires_onset)


@compiled
def mcp_torque(h, y, f):
    """Passive torque (N m) of finger f's MCP joint."""
    spring = (h.mcp_spring_stiffness, h.mcp_spring_preload)
    stop = (h.mcp_stop_stiffness, h.mcp_stop_damping, h.mcp_stop_onset)
    drag = friction(
        y[10 + 2 * f],
        h.mcp_breakaway_friction,
        h.mcp_coulomb_friction,
        h.mcp_breakaway_speed,
        h.mcp_viscous_friction,
    )
    limits = (h.fingers_mcp_rest[f], h.fingers_mcp_upper[f])
    return spring_and_stops(y[2 * f], y[10 + 2 * f], limits, spring, stop) - drag


@compiled
def pip_torque(h, y, f):
    """Passive torque (N m) of finger f's PIP joint."""
    spring = (h.pip_spring_stiffness, h.pip_spring_preload)
    stop = (h.pip_stop_stiffness, h.pip_stop_damping, h.pip_stop_onset)
    drag = friction(
        y[11 + 2 * f],
        h.pip_breakaway_friction,
        h.pip_coulomb_friction,
        h.pip_breakaway_speed,
        h.pip_viscous_friction,
    )
    limits = (h.fingers_pip_rest[f], h.fingers_pip_upper[f])
    return spring_and_stops(y[2 * f + 1], y[11 + 2 * f], limits, spring, stop) - drag


@compiled
def finger_rates(h, y, f, tension, dy):
    """Writes finger f's rates; its normal force on the object (N)."""
    i, j = 2 * f, 2 * f + 1
    torques = (
        mcp_torque(h, y, f) + h.mcp_moment_arm * tension,
        pip_torque(h, y, f) + h.pip_moment_arm * tension,
    )
    lengths = (h.fingers_proximal_length[f], h.fingers_distal_length[f])
    masses = (h.fingers_proximal_mass[f], h.fingers_distal_mass[f])
    gravity = (h.gravity_x, h.fingers_side[f] * h.gravity_y)
    disc = (h.section_x[f], h.section_y[f], h.section_radius[f], h.fingers_radius[f])
    law = (
        h.object_stiffness,
        h.object_damping,
        h.object_friction,
        h.contact_onset,
        h.contact_slip_speed,
    )
    angles, speeds = (y[i], y[j]), (y[10 + i], y[10 + j])
    dy[i], dy[j] = speeds
    dy[10 + i], dy[10 + j], force = finger(
        angles, speeds, torques, lengths, masses, gravity, disc, law
    )
    return force


@compiled
def mechanics(h, y, dy):
    """Writes the rates of fingers, carts and motor; the sum of normal forces (N)."""
    leader = leader_tension(h, y)
    force = finger_rates(h, y, 4, leader, dy)
    for c in range(2):
        tension = follower_tension(h, y, c)
        force += finger_rates(h, y, 2 * c, tension, dy)
        force += finger_rates(h, y, 2 * c + 1, tension, dy)
        drag = friction(
            y[22 + c],
            h.cart_breakaway_friction,
            h.cart_coulomb_friction,
            h.cart_breakaway_speed,
            h.cart_viscous_friction,
        )
        dy[20 + c] = y[22 + c]
        dy[22 + c] = (2.0 * leader - 2.0 * tension - drag) / h.cart_mass
    load = h.gear_pulley_radius * leader / h.gear_ratio
    drag = drive_friction(
        y[25],
        load,
        h.motor_dry_friction,
        h.asymmetry,
        h.load_loss,
        h.motor_friction_speed,
        h.motor_viscous_friction,
    )
    dy[24] = y[25]
    dy[25] = (h.motor_torque_constant * y[26] - drag - load) / h.motor_inertia
    return force


@compiled
def rates(h, y, reference, duty, is_sampled, dy):
    """Writes all rates; `duty` is used only where the controller is sampled. Returns duty, force.

    reference (rad): motor side.
    """
    force = mechanics(h, y, dy)
    if is_sampled:
        dy[27], dy[28], dy[29] = 0.0, 0.0, 0.0
    else:
        duty, dy[27], dy[28], dy[29] = continuous(h, reference, y[24], y[26], y[27], y[28], y[29])
    volts = duty * h.supply_voltage - h.motor_resistance * y[26]
    dy[26] = (volts - h.motor_torque_constant * y[25]) / h.motor_inductance
    return duty, force


def rest_state(h) -> np.ndarray:
    """Everything at its rest angle and still: an exact equilibrium without gravity."""
    y = np.zeros(SIZE)
    y[0:10:2], y[1:10:2] = h.fingers_mcp_rest, h.fingers_pip_rest
    return y
