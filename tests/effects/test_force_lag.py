"""force_lag: its equation written a second time, its signature in a run."""

import math

import numpy as np
import pytest
from effect_contract import check_equations, lag, runs


def test_equation():
    check_equations("force_lag", {"grip": lag, "face": lag})


def test_signature():
    bare, run = runs("force_lag", "dynamometer", time=0.05)
    for name in ("force", "sensor"):
        now, logged, step = bare[name], run[name], math.exp(-1e-3 / 0.05)
        filtered = [0.0]
        for each in 0.5 * (now[1:] + now[:-1]):
            filtered.append(step * filtered[-1] + (1.0 - step) * each)
        assert np.abs(logged - filtered).max() < 1e-3 * now.max()
    assert run["position"] == pytest.approx(bare["position"], abs=1e-4)
