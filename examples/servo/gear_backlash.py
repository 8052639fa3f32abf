"""Backlash: play between gear and shaft, which is crossed when load or motion changes sides.

The shaft carries the load and the position sensor. Between the faces of the gear it flies, by its
weight and its own friction; at a face it goes with the gear. A free shaft does not load the motor,
one that is carried along does, by its weight and its friction.
"""

import math

from hannes import Effect, Parameter, Slot, Term, kernel

FACE = 2e3  # 1/s, at which a face stops the shaft
LEAST = 2e-4  # rad, of a gap in which a place is counted
REST_LOAD = 1e-3  # N m, from which on a load presses on a face
REST = 2e-3  # rad/s, within which the shaft's dry friction turns


@kernel
def lain(gravity_torque, gravity_angle, first_command):
    """Where the shaft lies at first, from -1 to 1: on the face that gravity presses."""
    return -math.tanh(gravity_torque * math.sin(first_command + gravity_angle) / REST_LOAD)


@kernel
def falling(load, turning, motor_inertia, gear_ratio, hold, beyond):
    """Rate of the shaft's speed by its load [N m, at the motor] and its own friction [rad/s2]."""
    against = load * gear_ratio + hold * math.tanh(turning / REST)
    return -against / (beyond * motor_inertia * gear_ratio * gear_ratio)


@kernel
def ahead(
    motor_angle, motor_speed, motor_inertia, gear_ratio, gravity_torque, gravity_angle,
    first_command, travelled, flight, gap, hold, beyond,
):  # fmt: skip
    """How far the shaft went beside the gear [rad], rates of its place there and its speed."""
    first = lain(gravity_torque, gravity_angle, first_command)
    place, turning = first + travelled, motor_speed / gear_ratio
    within = min(max(place, -1.0), 1.0)
    went = 0.5 * gap * (within - first)
    load = gravity_torque * math.sin(motor_angle / gear_ratio + went + gravity_angle) / gear_ratio
    slip, speed = flight - turning, flight
    pressed = abs(place) >= 0.999 and place * slip > 0.0
    if pressed:
        speed = turning
    rate = falling(load, speed, motor_inertia, gear_ratio, hold, beyond)
    if pressed:
        rate -= FACE * slip
    half = 0.5 * max(gap, LEAST)
    return went, slip / half - FACE * (place - within), rate


@kernel
def apart(
    drive_torque, gear_friction, load, motor_speed, motor_inertia, gear_ratio, gravity_torque,
    gravity_angle, first_command, travelled, flight, gap, beyond,
):  # fmt: skip
    """What the rotor gains by a shaft that flies, and by one that strikes a face [N m].

    The rotor has the inertia that is not the shaft's, and nothing but a face hands on a load.
    """
    place = lain(gravity_torque, gravity_angle, first_command) + travelled
    slip, strike = flight - motor_speed / gear_ratio, 0.0
    if abs(place) >= 0.999 and place * slip > 0.0:
        strike = beyond * motor_inertia * gear_ratio * FACE * slip
    moves = drive_torque - gear_friction
    return ((beyond * moves + strike) / (1.0 - beyond) + load) * min(gap / LEAST, 1.0)


EFFECT = Effect(
    name="gear_backlash",
    meaning="Gear and shaft have play: the shaft flies from face to face.",
    equation="q = th / N + z, |z| <= gap / 2; free within, J q'' = -T_gravity - hold",
    source="Nordin & Gutman (2002), two bodies with backlash, inelastic faces",
    parameters=(
        Parameter("gap", 0.0, "rad", (0.0, 0.1), "whole play, at the shaft", off=0.0),
        Parameter("hold", 0.02, "N m", (2e-3, 0.5), "of the shaft alone", tried=(0.02, 0.2)),
        Parameter("beyond", 0.1, "1", (0.02, 0.9), "share of inertia there", tried=(0.1,)),
    ),
    terms=(
        Term(ahead, writes=("shaft_position",), states=("travelled", "flight")),
        Term(apart, writes=("motor_torque",), unit="N m"),
    ),
    states=(
        Slot("travelled", "1", "by the shaft in the gap, in halves of it", tolerance=1e-3),
        Slot("flight", "rad/s", "speed of the shaft", tolerance=1e-3),
    ),
)
