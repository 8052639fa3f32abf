"""current_lag: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from effect_contract import check_equations, lag, runs


def test_equation():
    check_equations("current_lag", {"trailing": lag})


def test_signature():
    """The log is an exponential mean of what flows."""
    _, run = runs("current_lag", "finely", time=2e-3)
    now, logged, time = run["motor_current"], run["current"], 2e-3
    mean, step = 0.5 * (now[1:] + now[:-1]), math.exp(-5e-5 / time)
    filtered = [0.0]
    for each in mean:
        filtered.append(step * filtered[-1] + (1.0 - step) * each)
    assert logged == pytest.approx(np.array(filtered), abs=1e-4)
    assert np.abs(logged - now).max() > 0.01
