"""bridge_dead_time: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, mean, runs, sign


def test_equation():
    check_equations(
        "bridge_dead_time", {"blanked": lambda i, supply, share: -share * supply * sign(i / 0.02)}
    )


def test_signature():
    """The loop asks for that much more duty, in the direction of the current."""
    bare, run = runs("bridge_dead_time", "void", share=0.03)
    assert mean(bare, "current", 0.2, 0.3) > 0.1
    more = mean(run, "duty", 0.2, 0.3) - mean(bare, "duty", 0.2, 0.3)
    assert more == pytest.approx(0.03, abs=1e-3)
