"""gear_load: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, check_loss, mean, parameter, runs, sign, torque


def way(motor_speed, motor_friction_speed):
    return sign(motor_speed / motor_friction_speed)


def test_equation():
    check_equations("gear_load", {"load_loss": lambda w, ws, load, mu: mu * abs(load) * way(w, ws)})


def test_signature():
    bare, run = runs("gear_load", "dynamometer", coefficient=0.05)
    arm = parameter("gear.pulley_radius") / parameter("gear.ratio")
    before, after = (arm * mean(r, "leader_tension", 0.4, 0.5) for r in (bare, run))
    more = torque(run, 0.4, 0.5) - torque(bare, 0.4, 0.5) - (after - before)
    assert more == pytest.approx(0.05 * after, rel=0.02) and after < before


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("gear_load.coefficient", "gear_friction")
