"""Autocorrelation of what a model leaves: seen where it is, and hardly ever where it is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis.residual_tests import autocorrelated, channel_excess
from hannes.identification.diagnosis.tuning import VERDICT

BINS, NAMES = 115, ("current", "position")


def left(seed, level=1.0, slow=0.0):
    """Two runs of which noise of a level is left, and in one channel of one a slow wave besides."""
    groups = [
        SimpleNamespace(names=NAMES, bins=BINS, entries=[SimpleNamespace(name=name)])
        for name in ("closing", "grasp")
    ]
    residual = level * np.random.default_rng(seed).standard_normal(4 * BINS)
    residual[3 * BINS :] += slow * np.cos(3.0 * np.pi * (np.arange(BINS) + 0.5) / BINS)
    model = SimpleNamespace(groups=groups)
    noise = SimpleNamespace(simulated_noise=True)
    return SimpleNamespace(residual=residual, model=model, noise=noise)


@pytest.mark.parametrize("level", [0.5, 1.0, 2.0])
def test_noise_alone_is_hardly_ever_autocorrelated_whatever_its_level(level):
    alarms = [autocorrelated(left(seed, level)) is not None for seed in range(400)]
    assert np.mean(alarms) < 2.5 * VERDICT.residual_p_value


def test_a_slow_wave_far_below_the_noise_is_found_where_it_is():
    for seed in range(10):
        point = left(seed, slow=1.1)
        assert (
            point.residual @ point.residual < 1.3 * point.residual.size
        )  # which all bins together do not see
        found = autocorrelated(point)
        assert found is not None and found.where == "the position of runs like grasp"
        assert found.p_value < VERDICT.residual_p_value and found.excess > 0.0


def test_noise_whose_colour_few_repeats_say_is_hardly_ever_autocorrelated():
    """Residuals whitened by too little colour keep some, which two repeats cannot rule out."""
    for repeats, found in ((0, False), (400, True)):
        point = left(1)
        slow = np.convolve(np.random.default_rng(7).standard_normal(BINS + 2), np.ones(3), "valid")
        point.residual[:BINS] = 0.6 * slow
        point.noise.simulated_noise = False
        for group in point.model.groups:
            group.count = 1 + repeats
        assert (autocorrelated(point) is not None) is found


def test_a_run_of_few_bins_is_not_tested():
    point = left(1)
    for group in point.model.groups:
        group.bins = 30
    assert autocorrelated(point) is None


STEP = np.where(np.arange(BINS) < 70, -1.0, 1.0)  # of a force that comes at one angle


def refitted(seed, level=1.0, step=0.0):
    """The same after a fit of what takes nearly all that is slow, to noise and a step in one."""
    rng = np.random.default_rng([seed, 1])
    point = left(seed, level)
    point.residual[:BINS] += step * STEP
    x = (np.arange(BINS) + 0.5) / BINS
    columns = np.zeros((40, 4 * BINS))
    for k in range(4):
        for wave in range(10):
            columns[10 * k + wave, k * BINS : (k + 1) * BINS] = 3.0 * np.cos(np.pi * wave * x)
    point.residual += rng.standard_normal(40) @ columns
    point.jacobian, point.active = columns, np.arange(40)
    point.hessian = columns @ columns.T + np.eye(40)
    point.residual = (
        point.residual - np.linalg.solve(point.hessian, columns @ point.residual) @ columns
    )
    point.gradient = np.zeros(40)
    return point


@pytest.mark.parametrize("level", [0.7, 1.0, 1.4])
def test_noise_after_a_fit_hardly_ever_has_a_channel_excess(level):
    alarms = [channel_excess(refitted(seed, level)) is not None for seed in range(200)]
    assert np.mean(alarms) < 2.5 * VERDICT.residual_p_value


def test_a_step_after_a_fit_is_an_excess_though_hardly_autocorrelated():
    fitted_runs = {channel_excess: 0, autocorrelated: 0}
    for seed in range(20):
        point = refitted(seed, step=5.2)
        assert point.residual @ point.residual < 1.35 * point.residual.size
        found = channel_excess(point)
        fitted_runs[channel_excess] += (
            found is not None and "current of runs like closing" in found.where
        )
        fitted_runs[autocorrelated] += autocorrelated(point) is not None
    assert fitted_runs[channel_excess] >= 17
    assert fitted_runs[autocorrelated] <= 0.5 * fitted_runs[channel_excess]


def test_a_fit_that_is_not_at_its_end_is_judged_as_if_it_were():
    there, before = refitted(5, step=5.0), refitted(5, step=5.0)
    step = np.full(40, 0.3)
    before.residual = there.residual + step @ there.jacobian
    before.gradient = there.hessian @ step
    assert channel_excess(before).excess == pytest.approx(channel_excess(there).excess, rel=1e-6)


def test_no_channel_excess_where_noise_is_known_from_repeats_alone():
    point = refitted(1, step=9.0)
    assert channel_excess(point) is not None
    point.noise.simulated_noise = False
    assert channel_excess(point) is None


def test_few_bins_have_no_channel_excess():
    point = refitted(1, step=9.0)
    for group in point.model.groups:
        group.bins = 30
    assert channel_excess(point) is None
