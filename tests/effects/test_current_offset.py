"""current_offset: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, mean, runs


def test_equation():
    check_equations("current_offset", {"shifted": lambda offset: offset})


def test_signature():
    bare, run = runs("current_offset", "void", offset=0.05)
    assert run["current"] - run["motor_current"] == pytest.approx(0.05)
    more = mean(run, "current", 0.2, 0.3) - mean(bare, "current", 0.2, 0.3)
    assert more == pytest.approx(0.05, rel=0.02)
