"""direction_friction: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, parameter, runs, sign, torque


def way(motor_speed, motor_friction_speed):
    return sign(motor_speed / motor_friction_speed)


def test_equation():
    check_equations(
        "direction_friction",
        {
            "asymmetry": lambda w, dry, ws, viscous, a, b: (
                a * dry * abs(way(w, ws)) + b * viscous * abs(w)
            )
        },
    )


def test_signature():
    bare, run = runs("direction_friction", "void", dry=0.2)
    for start, end in ((0.2, 0.3), (0.8, 0.9)):
        more = torque(run, start, end) - torque(bare, start, end)
        assert more == pytest.approx(0.2 * parameter("motor.dry_friction"), rel=0.05)


def test_signature_of_viscous():
    bare, run = runs("direction_friction", "void", viscous=0.4)
    for start, end in ((0.2, 0.3), (0.8, 0.9)):
        more = torque(run, start, end) - torque(bare, start, end)
        speed = float(np.mean(np.abs(run["motor_speed"][int(1e3 * start) : int(1e3 * end)])))
        lost = 0.4 * parameter("motor.viscous_friction") * speed
        assert more == pytest.approx(lost, rel=0.15)
