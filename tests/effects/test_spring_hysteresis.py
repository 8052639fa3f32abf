"""spring_hysteresis: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, check_loss, runs


def spring(angle, rest, stiffness, preload):
    return preload + stiffness * (angle - rest)


def test_equation():
    check_equations(
        "spring_hysteresis",
        {
            "rubbing": lambda q, w, rest, k, pre, z, share, width: (
                share * spring(q, rest, k, pre) * z,
                (w - abs(w) * z) / width,
            )
        },
    )


def test_signature():
    """Over closing and opening, twice the share of what the springs take in closing is lost."""
    bare, run = runs("spring_hysteresis", "void", share=0.2)
    taken = np.cumsum(bare["power_spring"]) * 1e-3
    lost = np.sum(run["power_spring"]) * 1e-3 - taken[-1]
    assert lost == pytest.approx(2.0 * 0.2 * taken.max(), rel=0.25)  # less what turning takes


def test_what_is_lost_to_it_stands_in_the_ledger():
    check_loss("spring_hysteresis.share", "spring")
