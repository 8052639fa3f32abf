"""supply_sag: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, runs


def test_equation():
    check_equations("supply_sag", {"sag": lambda duty, current, r: -r * duty * current})


def test_signature():
    bare, run = runs("supply_sag", "dynamometer", resistance=0.5)
    assert run["supply"] == pytest.approx(12.0 - 0.5 * run["duty"] * run["motor_current"])
    assert run["supply"].min() < 11.0 < 11.99 < bare["supply"].min()
    assert run["duty"].max() > bare["duty"].max()
