"""Rates of the whole hand's state, from the motor out to the fingertips."""

import numpy as np

from benchmarks.truth._jit import compiled
from benchmarks.truth.controller import continuous
from benchmarks.truth.effects import (
    encoder_eccentricity,
    guide_load,
    jammed_cart,
    sheath_edge,
    striking_thumb,
    warming_grease,
    wire_creep,
)
from benchmarks.truth.finger import finger
from benchmarks.truth.joints import mcp_torque, pip_torque
from benchmarks.truth.laws import friction
from benchmarks.truth.motor import follow_shaft, sense_current, sense_force, turn, wind
from benchmarks.truth.state import (
    ANGLE,
    CART,
    CART_SPEED,
    CREPT,
    DENT,
    MOTOR,
    MOTOR_SPEED,
    SHAFT,
    SIZE,
    SPEED,
)
from benchmarks.truth.wires import (
    excursion,
    follower_tensions,
    leader_pulls,
    leader_tension,
    moment_arms,
)


@compiled
def move(h, start, gain, y, dy):
    """Writes all positions from the speeds."""
    for k in range(10):
        y[ANGLE + k] = start[ANGLE + k] + gain * y[SPEED + k]
        dy[ANGLE + k] = y[SPEED + k]
    for c in range(2):
        y[CART + c] = start[CART + c] + gain * y[CART_SPEED + c]
        dy[CART + c] = y[CART_SPEED + c]
    y[MOTOR] = start[MOTOR] + gain * y[MOTOR_SPEED]
    dy[MOTOR] = y[MOTOR_SPEED]
    follow_shaft(h, start, gain, y, dy)
    warming_grease.spend(h, start, gain, y, dy)
    y[CREPT] = start[CREPT]  # micrometres a second: its own part-step may wait


@compiled
def finger_rates(h, f, tension, start, gain, y, dy):
    """Writes finger f's rates; its normal force on the object and its push on the face (N)."""
    i, j = 2 * f, 2 * f + 1
    mcp_arm, pip_arm = moment_arms(h, f)
    tension = sheath_edge.passed(h, tension, y[ANGLE + i], excursion(h, y, f)[1])
    opened = striking_thumb.push(h, f, y)
    torques = (
        mcp_torque(h, f, start, gain, y, dy) + mcp_arm * tension - opened,
        pip_torque(h, f, start, gain, y, dy) + pip_arm * tension,
    )
    lengths = (h.fingers_proximal_length[f], h.fingers_distal_length[f])
    masses = (h.fingers_proximal_mass[f], h.fingers_distal_mass[f])
    gravity = (h.gravity_x, h.fingers_side[f] * h.gravity_y)
    disc = (
        h.section_x[f],
        h.section_y[f],
        h.section_radius[f],
        h.fingers_radius[f],
        h.section_half_x,
        h.section_half_y,
    )
    law = (
        h.object_stiffness,
        h.object_damping,
        h.object_friction,
        h.object_onset,
        h.object_slip_speed,
        h.hunt_crossley_exponent,
        h.hunt_crossley_dissipation,
        h.viscoelastic_object_share,
        h.viscoelastic_object_time,
        h.soft_pad_thickness,
        h.soft_pad_stiffness,
    )
    angles, speeds = (y[ANGLE + i], y[ANGLE + j]), (y[SPEED + i], y[SPEED + j])
    dents = (start[DENT + i], start[DENT + j])
    rates, dented, force, face = finger(
        angles, speeds, torques, lengths, masses, gravity, disc, law, dents, gain
    )
    dy[SPEED + i], dy[SPEED + j] = rates
    y[DENT + i], y[DENT + j], dy[DENT + i], dy[DENT + j] = dented
    return force, face


@compiled
def cart_rate(h, c, leader, follower, y, dy):
    """Writes cart c's acceleration under the pulls (N) of the leader and of its follower."""
    drag = friction(
        y[CART_SPEED + c],
        h.cart_breakaway_friction,
        h.cart_coulomb_friction,
        h.cart_breakaway_speed,
        h.cart_viscous_friction,
    )
    drag += guide_load.drag(h, leader, y[CART_SPEED + c])
    drag += jammed_cart.drag(h, y[CART + c], y[CART_SPEED + c])
    dy[CART_SPEED + c] = (leader - follower - drag) / h.cart_mass


@compiled
def mechanics(h, start, gain, y, dy):
    """Writes the rates of fingers, carts, motor and shaft."""
    tension, lever = leader_tension(h, y)
    dy[CREPT] = wire_creep.speed(h, tension)
    pull_a, pull_b, thumb = leader_pulls(h, y, tension)
    force, face = finger_rates(h, 4, thumb, start, gain, y, dy)
    for c in range(2):
        one, two = follower_tensions(h, y, c)
        cart_rate(h, c, pull_a if c == 0 else pull_b, one + two, y, dy)
        more, also = finger_rates(h, 2 * c, one, start, gain, y, dy)
        force, face = force + more, face + also
        more, also = finger_rates(h, 2 * c + 1, two, start, gain, y, dy)
        force, face = force + more, face + also
    turn(h, lever * tension, y, dy)
    sense_force(h, force, face, start, gain, y, dy)


@compiled
def rates(h, start, gain, reference, duty, is_sampled, y, dy):
    """Completes y from its unknowns, with z = start + gain z' for the rest, and writes all rates.

    At gain 0, y is `start` and the rates are those at y. reference: motor side (rad); `duty` is
    used only where the controller is sampled. Returns duty, bus voltage and measured current.
    """
    move(h, start, gain, y, dy)
    mechanics(h, start, gain, y, dy)
    current = sense_current(h, start, gain, y, dy)
    if not is_sampled:
        position = encoder_eccentricity.seen(h, y[SHAFT]) * h.gear_ratio
        duty = continuous(h, reference, position, current, start, gain, y, dy)
    bus = wind(h, duty, y, dy)
    return duty, bus, current


def rest_state(h) -> np.ndarray:
    """Everything at its rest angle and still: an exact equilibrium without gravity."""
    y = np.zeros(SIZE)
    y[ANGLE : ANGLE + 10 : 2], y[ANGLE + 1 : ANGLE + 10 : 2] = (
        h.fingers_mcp_rest,
        h.fingers_pip_rest,
    )
    return y
