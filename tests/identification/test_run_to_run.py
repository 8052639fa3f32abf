"""Run-to-run variability that repeats show, against what was assumed."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from hannes.identification.diagnosis.run_to_run import (
    _Repeats,
    disagreement,
    observed_ratios,
    settings_from_repeats,
)
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import NOISE

BINS, REPEATS = 60, 6
TIME = np.linspace(0.0, 1.0, BINS)
ROWS = np.array([1.1 + np.sin(7.0 * TIME), 1.2 + np.cos(3.0 * TIME), 2.0 + np.sin(9.0 * TIME)])
STEADY = 0.05**2 * (np.eye(BINS) + 0.4 * np.eye(BINS, k=1) + 0.4 * np.eye(BINS, k=-1))


def noise(seed, machine, start, count=REPEATS, assumed=True):
    """Two commands, recorded so often by machines that differ so many times as far as ROWS."""
    rng = np.random.default_rng(seed)
    sizes = np.array([machine, machine, start])
    noise = np.linalg.cholesky(STEADY)
    groups = [
        SimpleNamespace(
            count=count,
            measured=TIME
            + rng.standard_normal((count, 3)) * sizes @ ROWS
            + rng.standard_normal((count, BINS)) @ noise.T,
        )
        for _ in range(2)
    ]
    means = [(STEADY + ROWS.T @ ROWS) / count] * 2
    model = SimpleNamespace(groups=groups)
    return SimpleNamespace(
        model=model, covariances=means, run_to_run=[ROWS] * 2, simulated_noise=assumed
    )


def test_a_right_assumption_stays():
    alarms = [observed_ratios(noise(seed, 1.0, 1.0)) for seed in range(200)]
    assert sum(each != (1.0, 1.0) for each in alarms) <= 3  # one in four hundred, by SURE


@pytest.mark.parametrize("truth", [(2.0, 2.0), (1.0, 3.0), (3.0, 1.0)])
def test_variability_assumed_too_small_is_found(truth):
    found = np.array([observed_ratios(noise(seed, *truth)) for seed in range(50)])
    assert (found == 1.0).all(axis=1).sum() <= 3
    assert np.median(found, axis=0) == pytest.approx(truth, abs=0.5)


def test_variability_assumed_too_large_is_found_and_rather_too_large():
    found = np.array([observed_ratios(noise(seed, 0.5, 0.5)) for seed in range(100)])
    assert (found == 1.0).all(axis=1).sum() <= 20  # repeats did not surely show less
    assert (found < 0.5).any(axis=1).sum() <= 6
    assert np.median(found, axis=0).tolist() == pytest.approx([0.7, 0.7], abs=0.1)


def test_of_two_repeats_nothing_smaller_is_taken():
    found = [observed_ratios(noise(seed, 0.5, 0.5, count=2)) for seed in range(50)]
    assert sum(each == (1.0, 1.0) for each in found) >= 45


def test_without_repeats_or_simulated_noise_nothing_is_concluded():
    assert observed_ratios(noise(0, 4.0, 4.0, count=1)) == (1.0, 1.0)
    assert observed_ratios(noise(0, 4.0, 4.0, assumed=False)) == (1.0, 1.0)


def test_settings_follow_what_repeats_show_and_say_so():
    assumed = Settings(0.01, 0.0025, 1e-4)
    observed = settings_from_repeats(noise(0, 4.0, 4.0), assumed)
    assert observed.scatter == NOISE.wider_scatter * assumed.scatter
    assert (
        observed.run_scatter > 2.0 * assumed.run_scatter
        and observed.start_time > 2.0 * assumed.start_time
    )
    (said,) = disagreement(assumed, observed)
    assert f"start_time {observed.start_time:.2g} s" in said
    assert settings_from_repeats(noise(0, 4.0, 4.0), Settings(0.15)).scatter == NOISE.widest_scatter
    assert settings_from_repeats(noise(0, 4.0, 4.0), Settings(0.3)).scatter == 0.3


def test_settings_that_repeats_bear_out_are_kept():
    assumed = Settings(0.02, 0.005, 2e-4)
    assert settings_from_repeats(noise(0, 1.0, 1.0), assumed) == assumed
    assert not disagreement(assumed, assumed)


def test_likelihood_is_that_of_the_normal_distribution():
    group = noise(3, 1.5, 2.0).model.groups[0]
    assumed = _Repeats.of(group, STEADY, ROWS)
    apart = np.sqrt(REPEATS / (REPEATS - 1.0)) * (group.measured - group.measured.mean(axis=0))

    def plain(machine, start):
        rows = np.array([machine, machine, start])[:, np.newaxis] * ROWS
        covariance = STEADY + rows.T @ rows
        each = multivariate_normal(np.zeros(BINS), covariance).logpdf(apart)
        return (REPEATS - 1.0) / REPEATS * float(each.sum())

    for pair in ((1.5, 2.0), (NOISE.excess_ratios[-1], 1.0)):
        gained = assumed.log_likelihood(*pair) - assumed.log_likelihood(1.0, 1.0)
        assert gained == pytest.approx(plain(*pair) - plain(1.0, 1.0), rel=1e-6)
    assert NOISE.excess_likelihood == pytest.approx(2.0 * -np.log(1 / 400), abs=0.1)
