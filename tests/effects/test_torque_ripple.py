"""torque_ripple: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from catalogued import ledger
from effect_contract import check_equations, parameter, runs


def test_equation():
    check_equations(
        "torque_ripple", {"ripple": lambda th, a, n, phase: a * math.sin(n * th + phase)}
    )


def test_signature():
    bare, run = runs("torque_ripple", "finely", amplitude=1e-3)
    at = slice(4000, 6000)
    speed, more = run["motor_speed"][at], run["motor_speed"][at] - bare["motor_speed"][at]
    expected = 1e-3 / (parameter("motor.inertia") * 4.0 * speed.mean())
    assert more.std() * math.sqrt(2.0) == pytest.approx(expected, rel=0.1)
    turns = np.ptp(run["motor_angle"][at]) * 4.0 / (2.0 * math.pi)
    crossings = np.count_nonzero(np.diff(np.sign(more - more.mean())))
    assert crossings / 2.0 == pytest.approx(turns, abs=1.5)


def test_the_ledger_gets_back_what_it_takes():
    found = ledger("torque_ripple.amplitude")
    assert 0.0 != abs(found["motor_torque"]) < 1e-3 * found["electrical"]
