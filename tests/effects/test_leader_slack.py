"""leader_slack: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, parameter, runs, touch


def test_equation():
    check_equations("leader_slack", {"free_length": lambda length: length})


def test_signature():
    bare, run = runs("leader_slack", "dynamometer", length=3e-3)
    speed = parameter("gear.pulley_radius") * 9.84 / 0.637
    assert touch(run) - touch(bare) == pytest.approx(3e-3 / speed, rel=0.1)
