"""stribeck: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from effect_contract import check_equations, parameter, runs, sign


def peak(motor_speed, torque, speed):
    u = motor_speed / (math.sqrt(2.0) * speed)
    return math.sqrt(2.0 * math.e) * torque * u * math.exp(-(u**2))


def test_equation():
    check_equations("stribeck", {"breakaway": peak})


def test_signature():
    bare, run = runs("stribeck", "finely", torque=2e-3)
    speed = run["motor_speed"][1:]
    law = sign(speed / parameter("motor.friction_speed"))
    law *= parameter("motor.dry_friction")
    more = run["power_gear_friction"][1:] / speed - law
    more -= parameter("motor.viscous_friction") * speed
    assert more.max() == pytest.approx(2e-3, rel=1e-3)
    assert speed[np.argmax(more)] == pytest.approx(20.0, rel=0.02)
    behind = bare["motor_angle"] - run["motor_angle"]
    assert behind[200] > 0.1 * bare["motor_angle"][200] and abs(behind[-1]) < 0.1
