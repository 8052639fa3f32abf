"""Scaled parameters and their bounds."""

from types import SimpleNamespace

import numpy as np

from hannes.identification.calibration.scaling import Scales


def test_a_value_on_its_bound_does_not_leave_it_by_the_last_bit():
    """Where x rounds, nominal plus x times scale is beside it: a plant would refuse that."""
    rng = np.random.default_rng(0)
    for low, span, at, scale in rng.uniform(0.1, 1.0, (200, 4)) * 1e-3:
        plan = SimpleNamespace(
            names=("arm",), scale={"arm": scale}, bounds={"arm": (low, low + span)},
            spread={"arm": scale},
        )  # fmt: skip
        scales = Scales.of(plan, {"arm": low + at})
        assert low <= scales.values(scales.low)["arm"]
        assert scales.values(scales.high)["arm"] <= low + span
        assert scales.values(scales.high + 1.0)["arm"] == low + span
