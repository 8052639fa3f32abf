"""wire_compliance: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, parameter, runs


def test_equation():
    check_equations(
        "wire_compliance",
        {"softer_leader": lambda leader: leader, "softer_follower": lambda follower: follower},
    )


def test_signature():
    """Compliance by the slope of stretch over tension, where neither moves much."""
    bare, run = runs("wire_compliance", "dynamometer", leader=5e-6)
    at = slice(610, 640)
    slopes = [
        np.polyfit(r["leader_tension"][at], r["leader_stretch"][at], 1)[0] for r in (bare, run)
    ]
    assert slopes[1] - slopes[0] == pytest.approx(5e-6, rel=0.05)


def test_signature_of_follower():
    bare, run = runs("wire_compliance", "dynamometer", follower=5e-6)
    arms = [parameter(f"{j}.moment_arm") for j in ("mcp", "pip")]
    slopes = []
    for each in (bare, run):
        bend = each["joint_angle"] - each["joint_angle"][0]
        taken = bend.reshape(-1, 5, 2) @ arms
        stretch = 2.0 * each["cart_position"][:, 0] - taken[:, 0] - taken[:, 1]
        at = slice(610, 640)
        slopes.append(np.polyfit(each["follower_tension"][at, 0], stretch[at], 1)[0])
    assert slopes[1] - slopes[0] == pytest.approx(5e-6, rel=0.05)
