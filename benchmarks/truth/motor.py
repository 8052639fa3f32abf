"""Motor, reducer and output shaft; winding and bus; sensors of current and force."""

from math import tanh

from benchmarks.truth._jit import compiled
from benchmarks.truth.added import bus_drop, current_error, duty_lost, rotor_torque
from benchmarks.truth.effects import (
    bridge_dead_time,
    current_gain,
    current_lag,
    current_offset,
    direction_friction,
    force_lag,
    force_saturation,
    gear_backlash,
    gear_load,
    pwm_dead_band,
    saturating_motor,
    stribeck,
    supply_sag,
    torque_ripple,
    warming_grease,
    winding_heating,
)
from benchmarks.truth.state import (
    CURRENT,
    FACE,
    FORCE_READING,
    MOTOR,
    MOTOR_SPEED,
    SENSED,
    SHAFT,
    SHAFT_SPEED,
    WORK,
)


@compiled
def drive_friction(h, speed, load):
    """Torque (N m) against the motor (rad/s) that carries a load (N m)."""
    way = tanh(speed / h.motor_friction_speed)
    dry, viscous = direction_friction.shares(h, way)
    level = dry * h.motor_dry_friction + gear_load.lost(h, load)
    return level * way + viscous * h.motor_viscous_friction * speed + stribeck.peak(h, speed)


@compiled
def follow_shaft(h, start, gain, y, dy):
    """Writes the shaft's angle, and its speed where no gap lets it have one of its own."""
    if h.gear_backlash_gap == 0.0:
        y[SHAFT], y[SHAFT_SPEED] = y[MOTOR] / h.gear_ratio, y[MOTOR_SPEED] / h.gear_ratio
    else:
        y[SHAFT] = start[SHAFT] + gain * y[SHAFT_SPEED]
    dy[SHAFT] = y[SHAFT_SPEED]


@compiled
def turn(h, pull, y, dy):
    """Writes the accelerations of motor and shaft; pull: the wire's torque on the shaft (N m)."""
    load = pull / h.gear_ratio
    if h.gear_backlash_gap != 0.0:
        lead = y[MOTOR] / h.gear_ratio - y[SHAFT]
        rate = y[MOTOR_SPEED] / h.gear_ratio - y[SHAFT_SPEED]
        torque = gear_backlash.teeth(h, lead, rate)
        dy[SHAFT_SPEED] = gear_backlash.shaft_rate(torque, pull, y[SHAFT_SPEED])
        load = torque / h.gear_ratio
    torque = winding_heating.torque_constant(h) * y[CURRENT]
    torque = saturating_motor.pulling(h, torque, y[CURRENT])
    torque += torque_ripple.cogging(h, y[MOTOR]) - drive_friction(h, y[MOTOR_SPEED], load) - load
    torque += warming_grease.missing(h, y[MOTOR_SPEED], y[WORK])
    torque -= rotor_torque(h, y[MOTOR], y[MOTOR_SPEED], load)
    dy[MOTOR_SPEED] = torque / h.motor_inertia


@compiled
def wind(h, duty, y, dy):
    """Writes the current's rate; the bus voltage (V)."""
    bus = supply_sag.bus(h, duty, y[CURRENT]) - bus_drop(h, duty, y[CURRENT])
    passed = pwm_dead_band.passed(h, duty) - duty_lost(h, duty)
    volts = passed * bus - winding_heating.resistance(h) * y[CURRENT]
    volts -= winding_heating.torque_constant(h) * y[MOTOR_SPEED]
    volts -= bridge_dead_time.volts_lost(h, y[CURRENT])
    dy[CURRENT] = volts / h.motor_inductance
    return bus


@compiled
def sense_current(h, start, gain, y, dy):
    """Reading of the current sensor (A), without noise; writes its filter."""
    y[SENSED], dy[SENSED] = current_lag.filtered(h, start[SENSED], gain, y[CURRENT])
    reading = current_offset.shifted(h, current_gain.amplified(h, y[SENSED]))
    return reading + current_error(h, y[SENSED])


@compiled
def sense_force(h, force, face, start, gain, y, dy):
    """Writes both force channels (N) as the dynamometer's amplifier reads them."""
    force, face = force_saturation.seen(h, force), force_saturation.seen(h, face)
    y[FORCE_READING], dy[FORCE_READING] = force_lag.filtered(h, start[FORCE_READING], gain, force)
    y[FACE], dy[FACE] = force_lag.filtered(h, start[FACE], gain, face)
