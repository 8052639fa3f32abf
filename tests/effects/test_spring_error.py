"""spring_error: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, mean, runs


def spring(angle, rest, stiffness, preload):
    return preload + stiffness * (angle - rest)


def test_equation():
    check_equations(
        "spring_error", {"stronger": lambda q, rest, k, pre, share: share * spring(q, rest, k, pre)}
    )


def test_signature():
    bare, run = runs("spring_error", "void", share=0.2)
    assert mean(run, "leader_tension", 0.2, 0.3) > mean(bare, "leader_tension", 0.2, 0.3)
    before, after = (np.cumsum(r["power_spring"])[600] for r in (bare, run))
    assert after / before == pytest.approx(1.2, rel=0.01)
