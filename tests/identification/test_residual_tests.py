"""What hangs together in what a model leaves: seen where it is, and hardly ever where it is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis.residual_tests import CHANCE, hangs_together, stands_out

BINS, NAMES = 115, ("current", "position")


def left(seed, level=1.0, slow=0.0):
    """Two runs of which noise of a level is left, and in one channel of one a slow wave besides."""
    groups = [
        SimpleNamespace(names=NAMES, bins=BINS, entries=[SimpleNamespace(name=name)])
        for name in ("closing", "grasp")
    ]
    miss = level * np.random.default_rng(seed).standard_normal(4 * BINS)
    miss[3 * BINS :] += slow * np.cos(3.0 * np.pi * (np.arange(BINS) + 0.5) / BINS)
    ground = SimpleNamespace(model=SimpleNamespace(groups=groups), told=True)
    return SimpleNamespace(miss=miss, ground=ground)


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


STEP = np.where(np.arange(BINS) < 70, -1.0, 1.0)  # of a force that comes at one angle


def refitted(seed, level=1.0, step=0.0):
    """The same after a fit of what takes nearly all that is slow, to noise and a step in one."""
    rng = np.random.default_rng([seed, 1])
    point = left(seed, level)
    point.miss[:BINS] += step * STEP
    x = (np.arange(BINS) + 0.5) / BINS
    columns = np.zeros((40, 4 * BINS))
    for k in range(4):
        for wave in range(10):
            columns[10 * k + wave, k * BINS : (k + 1) * BINS] = 3.0 * np.cos(np.pi * wave * x)
    point.miss += rng.standard_normal(40) @ columns
    point.columns, point.active = columns, np.arange(40)
    point.curvature = columns @ columns.T + np.eye(40)
    point.miss = point.miss - np.linalg.solve(point.curvature, columns @ point.miss) @ columns
    point.pull = np.zeros(40)
    return point


@pytest.mark.parametrize("level", [0.7, 1.0, 1.4])
def test_what_a_fit_leaves_of_noise_hardly_ever_stands_out(level):
    alarms = [stands_out(refitted(seed, level)) is not None for seed in range(200)]
    assert np.mean(alarms) < 2.5 * CHANCE


def test_what_a_fit_leaves_of_a_step_stands_out_though_it_hardly_hangs_together():
    seen = {stands_out: 0, hangs_together: 0}
    for seed in range(20):
        point = refitted(seed, step=4.5)
        assert point.miss @ point.miss < 1.3 * point.miss.size
        found = stands_out(point)
        seen[stands_out] += found is not None and "current of runs like closing" in found.where
        seen[hangs_together] += hangs_together(point) is not None
    assert seen[stands_out] >= 17
    assert seen[hangs_together] <= 0.5 * seen[stands_out]


def test_a_fit_that_is_not_at_its_end_is_judged_as_if_it_were():
    there, before = refitted(5, step=5.0), refitted(5, step=5.0)
    step = np.full(40, 0.3)
    before.miss = there.miss + step @ there.columns
    before.pull = there.curvature @ step
    assert stands_out(before).excess == pytest.approx(stands_out(there).excess, rel=1e-6)


def test_nothing_stands_out_where_only_repeats_tell_of_the_noise():
    point = refitted(1, step=9.0)
    assert stands_out(point) is not None
    point.ground.told = False
    assert stands_out(point) is None


def test_few_bins_stand_out_of_nothing():
    point = refitted(1, step=9.0)
    for group in point.ground.model.groups:
        group.bins = 30
    assert stands_out(point) is None
