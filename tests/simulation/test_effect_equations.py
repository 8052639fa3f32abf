"""Kernels of the catalogue against their equations, written a second time."""

import math

import numpy as np
import pytest
from catalogued import CATALOGUE

from hannes.core.kernels.jit import plain


def sign(x):
    return np.tanh(x)


def friction_of_capstan(leader_tension, rate_a, rate_b, rate_thumb, friction):
    speeds = np.cumsum([rate_thumb + rate_b, rate_b, rate_a])[::-1]
    tensions = leader_tension * np.exp(-friction * np.pi * np.cumsum(sign(speeds / 5e-3)))
    spans = np.array([leader_tension, *tensions])
    return *(0.5 * (spans[[0, 2]] + spans[[1, 3]]) - leader_tension), spans[3] - leader_tension


def ratio_of_ends(follower_slip, friction):
    ends = np.exp(-friction * np.pi * sign(follower_slip / 5e-3))  # first finger's to second's
    return (1.0 - ends) / (1.0 + ends)


def peak(motor_speed, torque, speed):
    u = motor_speed / (math.sqrt(2.0) * speed)
    return math.sqrt(2.0 * math.e) * torque * u * math.exp(-(u**2))


def way(motor_speed, motor_friction_speed):
    return sign(motor_speed / motor_friction_speed)


def spring(angle, rest, stiffness, preload):
    return preload + stiffness * (angle - rest)


def deep(x, rate, k, exponent, dissipation):
    if x <= 0.0:
        return 0.0
    return k * x * (x / 1e-3) ** exponent * (1.0 + dissipation * rate) - k * x


def crept(x, k, state, share, time):
    d = share * state
    return -k * d, (share * max(0.0, x - d) - d) / time / share


def lag(now, state, time):
    return state - now, (now - state) / time


def clip(x, limit):
    """A corner that is round over 2 % at either side is left out of the comparison."""
    return min(max(x, -limit), limit)


LAWS = {
    "leader_slack.free_length": lambda length: length,
    "wire_compliance.softer_leader": lambda leader: leader,
    "wire_compliance.softer_follower": lambda follower: follower,
    "capstan.along_leader": friction_of_capstan,
    "capstan.over_cart": ratio_of_ends,
    "gear_load.load_loss": lambda w, ws, load, mu: mu * abs(load) * way(w, ws),
    "direction_friction.asymmetry": lambda w, dry, ws, viscous, a, b: (
        a * dry * abs(way(w, ws)) + b * viscous * abs(w)
    ),
    "stribeck.breakaway": peak,
    "gear_backlash.lost_turn": lambda th, ratio, gap: -clip(th / ratio, gap / 2),
    "gear_backlash.lost_wire": lambda th, ratio, r, gap: r * clip(th / ratio, gap / 2),
    "torque_ripple.ripple": lambda th, a, n, phase: a * math.sin(n * th + phase),
    "winding_heating.warm": lambda r, k, rise: (r * 3.93e-3 * rise, -k * 1.1e-3 * rise),
    "supply_sag.sag": lambda duty, current, r: -r * duty * current,
    "pwm_dead_band.swallowed": lambda duty, width: -clip(duty, width),
    "spring_error.stronger": lambda q, rest, k, pre, share: share * spring(q, rest, k, pre),
    "spring_hysteresis.rubbing": lambda q, w, rest, k, pre, z, share, width: (
        share * spring(q, rest, k, pre) * z,
        (w - abs(w) * z) / width,
    ),
    "hunt_crossley.deepening": deep,
    "viscoelastic_object.creeping": crept,
    "object_misplacement.moved": lambda x, y: (x, y),
    "current_offset.shifted": lambda offset: offset,
    "current_gain.exaggerated": lambda current, error: error * current,
    "current_lag.trailing": lag,
    "force_lag.grip": lag,
    "force_lag.face": lag,
    "command_delay.late": lambda time: -time,
    "measurement_delay.late_position": lambda x, held, sampled, p, q, time: (
        (held - x, 0.0, 0.0) if sampled > 0.5 else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
    ),
    "measurement_delay.late_current": lambda x, held, sampled, p, q, time: (
        (held - x, 0.0, 0.0) if sampled > 0.5 else (-q, q / time, (12.0 * (x - p) - 6.0 * q) / time)
    ),
    "measurement_delay.age": lambda time: time,
}
SIZES = {  # of arguments, where they are not of the order of 1
    "penetration": 5e-3,
    "penetration_rate": 0.2,
    "crept": 1e-3,
    "follower_slip": 1e-2,
    "rate_a": 1e-2,
    "rate_b": 1e-2,
    "rate_thumb": 1e-2,
    "motor_speed": 30.0,
    "motor_friction_speed": 5.0,
    "object_stiffness": 1e4,
}


def test_every_kernel_has_its_law_here():
    names = {f"{e.name}.{plain(t.kernel).__name__}" for e in CATALOGUE.values() for t in e.terms}
    assert names == set(LAWS)


@pytest.mark.parametrize("law", LAWS)
def test_kernel_is_its_equation(law):
    effect = CATALOGUE[law.partition(".")[0]]
    (term,) = (t for t in effect.terms if law.endswith("." + plain(t.kernel).__name__))
    bounds, rng = {each.name: each.bounds for each in effect.parameters}, np.random.default_rng(5)
    for _ in range(300):
        given = [
            rng.uniform(*bounds[name]) if name in bounds else rng.normal() * SIZES.get(name, 1.0)
            for name in term.arguments
        ]
        mine, expected = np.ravel(term.kernel(*given)), np.ravel(LAWS[law](*given))
        rounded = 0.02 * np.abs(expected) if "backlash" in law else 0.0
        size = np.abs(expected) + 1e-12
        assert (np.abs(mine - expected) <= 1e-9 * size + rounded).all(), given
