"""clipped_current: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, runs


def cut(current, inverse_range):
    """What exceeds the range, negated."""
    return np.clip(current, -1.0 / inverse_range, 1.0 / inverse_range) - current


def test_equation():
    check_equations("clipped_current", {"cut_off": cut})


def test_signature():
    """It reads what there is up to its range, and no more."""
    bare, run = runs("clipped_current", "dynamometer", inverse_range=1.0)
    assert bare["current"].max() > 1.2
    assert run["current"].max() == pytest.approx(1.0)
    quiet = np.abs(run["motor_current"]) < 1.0
    assert run["current"][quiet] == pytest.approx(run["motor_current"][quiet])
