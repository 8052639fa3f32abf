"""guide_load: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, check_loss, parameter, runs, sign


def test_equation():
    check_equations(
        "guide_load", {"pressed": lambda v, vb, pull, mu: 2.0 * mu * abs(pull) * sign(v / vb)}
    )


def test_signature():
    """While the hand closes, the followers lack the share of the leader's pull that guides take."""
    bare, run = runs("guide_load", "void", coefficient=0.1)
    at = (run.time > 0.2) & (run.time < 0.25)
    lost = []
    for each in (bare, run):
        pull = 2.0 * each["leader_tension"][at] - 2.0 * each["follower_tension"][at, 0]
        lost.append(np.mean(pull / (2.0 * each["leader_tension"][at])))
    speed = np.mean(run["cart_speed"][at, 0])
    way = sign(speed / parameter("cart.breakaway_speed"))
    assert lost[1] - lost[0] == pytest.approx(0.1 * way, rel=0.15)


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("guide_load.coefficient", "cart_friction")
