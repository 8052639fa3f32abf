"""What hangs together in what a model leaves: seen where it is, and hardly ever where it is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.diagnosis.remainder import CHANCE, hangs_together

BINS, NAMES = 115, ("current", "position")


def left(seed, level=1.0, slow=0.0):
    """Two runs of which noise of a level is left, and in one channel of one a slow wave besides."""
    groups = [
        SimpleNamespace(names=NAMES, bins=BINS, entries=[SimpleNamespace(name=name)])
        for name in ("closing", "grasp")
    ]
    miss = level * np.random.default_rng(seed).standard_normal(4 * BINS)
    miss[3 * BINS :] += slow * np.cos(3.0 * np.pi * (np.arange(BINS) + 0.5) / BINS)
    return SimpleNamespace(miss=miss, ground=SimpleNamespace(model=SimpleNamespace(groups=groups)))


@pytest.mark.parametrize("level", [0.5, 1.0, 2.0])
def test_noise_alone_hardly_ever_hangs_together_whatever_its_level(level):
    alarms = [hangs_together(left(seed, level)) is not None for seed in range(400)]
    assert np.mean(alarms) < 2.5 * CHANCE


def test_a_slow_wave_far_below_the_noise_is_found_where_it_is():
    for seed in range(10):
        point = left(seed, slow=0.9)
        assert point.miss @ point.miss < 1.3 * point.miss.size  # which all bins together do not see
        found = hangs_together(point)
        assert found is not None and found.where == "the position of runs like grasp"
        assert found.chance < CHANCE and found.excess > 0.0


def test_a_run_of_few_bins_tells_nothing():
    point = left(1)
    for group in point.ground.model.groups:
        group.bins = 30
    assert hangs_together(point) is None
