"""winding_heating: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, check_loss, mean, parameter, runs


def test_equation():
    check_equations(
        "winding_heating", {"warm": lambda r, k, rise: (r * 3.93e-3 * rise, -k * 1.1e-3 * rise)}
    )


def test_signature():
    bare, run = runs("winding_heating", "void", rise=50.0)
    resists = run["power_copper"][1:] / run["motor_current"][1:] ** 2
    assert resists == pytest.approx(parameter("motor.resistance") * 1.1965)
    more = mean(run, "current", 0.2, 0.3) / mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(1.0 / 0.945, rel=0.01)


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("winding_heating.rise", "copper")
