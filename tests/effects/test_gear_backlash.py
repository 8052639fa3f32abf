"""gear_backlash: its equation written a second time, its signature in a run."""

import numpy as np
import pytest
from effect_contract import check_equations, parameter, runs


def clip(x, limit):
    """A corner that is round over 2 % at either side is left out of the comparison."""
    return min(max(x, -limit), limit)


def test_equation():
    check_equations(
        "gear_backlash",
        {
            "lost_turn": lambda th, ratio, gap: -clip(th / ratio, gap / 2),
            "lost_wire": lambda th, ratio, r, gap: r * clip(th / ratio, gap / 2),
        },
        rounded=0.02,
    )


def test_signature():
    """Half the play between motor and encoder; next to nothing in the log."""
    bare, run = runs("gear_backlash", "void", gap=0.02)
    ratio = parameter("gear.ratio")
    lost = run["motor_angle"][100:900] / ratio - run["position"][100:900]
    assert lost == pytest.approx(0.01, rel=1e-3)
    for name in ("position", "current", "duty"):
        assert np.abs(run[name] - bare[name])[100:900].max() < 2e-3 * np.ptp(bare[name])
