"""pwm_dead_band: its equation written a second time, its signature in a run."""

import pytest
from effect_contract import check_equations, mean, runs


def clip(x, limit):
    """A corner that is round over 2 % at either side is left out of the comparison."""
    return min(max(x, -limit), limit)


def test_equation():
    check_equations("pwm_dead_band", {"swallowed": lambda duty, width: -clip(duty, width)})


def test_signature():
    bare, run = runs("pwm_dead_band", "void", width=0.03)
    for start, end, sign in ((0.2, 0.3, 1.0), (0.8, 0.9, -1.0)):
        more = mean(run, "duty", start, end) - mean(bare, "duty", start, end)
        assert more == pytest.approx(sign * 0.03, abs=5e-4)
