"""capstan: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from effect_contract import check_equations, check_loss, mean, runs, sign


def friction_of_capstan(leader_tension, rate_a, rate_b, rate_thumb, friction):
    speeds = np.cumsum([rate_thumb + rate_b, rate_b, rate_a])[::-1]
    tensions = leader_tension * np.exp(-friction * np.pi * np.cumsum(sign(speeds / 5e-3)))
    spans = np.array([leader_tension, *tensions])
    return *(0.5 * (spans[[0, 2]] + spans[[1, 3]]) - leader_tension), spans[3] - leader_tension


def ratio_of_ends(follower_slip, friction):
    ends = np.exp(-friction * np.pi * sign(follower_slip / 5e-3))  # first finger's to second's
    return (1.0 - ends) / (1.0 + ends)


def test_equation():
    check_equations("capstan", {"along_leader": friction_of_capstan, "over_cart": ratio_of_ends})


def test_signature():
    """Closing on nothing, two pulleys lie between the carts' means."""
    bare, run = runs("capstan", "void", friction=0.05)
    at = (run.time > 0.2) & (run.time < 0.25)
    before, after = (
        np.mean(r["follower_tension"][at, 1] / r["follower_tension"][at, 0]) for r in (bare, run)
    )
    assert after / before == pytest.approx(math.exp(-2.0 * 0.05 * math.pi), rel=0.01)
    assert mean(run, "current", 0.2, 0.25) > mean(bare, "current", 0.2, 0.25)


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("capstan.friction", "wire_friction")
