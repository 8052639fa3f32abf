"""current_gain: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, mean, runs


def test_equation():
    check_equations("current_gain", {"exaggerated": lambda current, error: error * current})


def test_signature():
    bare, run = runs("current_gain", "void", error=0.1)
    assert run["current"] == pytest.approx(1.1 * run["motor_current"])
    more = mean(run, "current", 0.2, 0.3) / mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(1.1, rel=0.01)
