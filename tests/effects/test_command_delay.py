"""command_delay: its equation written a second time, its signature in a run."""

import numpy as np
from effect_contract import check_equations, runs


def test_equation():
    check_equations("command_delay", {"late": lambda time: -time})


def test_signature():
    bare, run = runs("command_delay", "dynamometer", time=0.01)
    for name in ("position", "current", "force"):
        gap = np.abs(run[name][10:] - bare[name][:-10])
        assert gap.max() < 5e-5 * np.ptp(bare[name])
