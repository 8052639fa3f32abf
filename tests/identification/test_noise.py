"""Noise of bin means: from repeats, from samples, and over time."""

import numpy as np
import pytest
from sled import Sled, recordings

from hannes.identification.diagnosis.antedependence import covariance
from hannes.identification.diagnosis.noise_model import Noise, of_repeats, white_levels
from hannes.identification.diagnosis.repeat_groups import grouped


def test_correlated_noise_is_found_and_is_a_covariance():
    groups = grouped(Sled(), recordings(1))
    rng = np.random.default_rng(5)
    for group in groups:
        white = rng.standard_normal((group.count, group.part.size + 9))
        smooth = np.apply_along_axis(np.convolve, 1, white, np.ones(10) / np.sqrt(10.0), "valid")
        group.measured = 1e-2 * smooth
    none = [np.zeros((1, group.part.size)) for group in groups]
    calm = [each[0] for each in none]
    noise = Noise(groups, *of_repeats(groups, calm, none, 1.0), calm, none, 1.0)
    for group in groups:
        covariance = noise.covariance(group)
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        near = np.diag(covariance, 1)[: group.bins - 1] / np.diag(covariance)[: group.bins - 1]
        assert 0.6 < near.mean() < 1.0
        assert np.sqrt(np.diag(covariance)).mean() == pytest.approx(1e-2, rel=0.3)


def test_noise_without_repeats_is_how_rough_samples_are():
    groups = grouped(Sled(), [recordings(1)[0], recordings(1)[4]])
    levels = white_levels(groups[0], {})
    per_bin = 2e-3 / np.sqrt(groups[0].recording.time.size / groups[0].bins)
    assert levels["position"] == pytest.approx(per_bin, rel=0.15)


def test_noise_is_correlated_as_it_is_at_its_time():
    rng = np.random.default_rng(5)
    quick, slow = rng.standard_normal((2, 2000, 60))
    for bin in range(1, 60):  # alone first, then each after the one before
        slow[:, bin] = 0.875 * slow[:, bin - 1] + np.sqrt(1.0 - 0.875**2) * slow[:, bin]
    deviations = np.hstack([quick[:, :30], slow[:, 30:]])
    found, beside = covariance(deviations, 1), np.arange(8, 22)
    assert np.diag(found)[8:52] == pytest.approx(np.ones(44), abs=0.15)
    assert found[beside, beside + 1] == pytest.approx(np.zeros(14), abs=0.1)
    assert found[beside + 30, beside + 31] == pytest.approx(np.full(14, 0.875), abs=0.1)
    assert np.linalg.eigvalsh(found).min() > 0.0


def test_forty_runs_show_how_small_a_loop_keeps_slow_changes():
    # Differences of white noise: their sum over a run is no more than one of them. Two channels,
    # the second what the first was before.
    rng = np.random.default_rng(6)
    white = rng.standard_normal((40, 101))
    one = np.diff(white)
    deviations = np.hstack([one, np.pad(one, ((0, 0), (1, 0)))[:, :-1]])
    found = covariance(deviations, 2)
    slow = np.cos(np.pi * (np.arange(100) + 0.5) / 50.0) / np.sqrt(50.0)
    found_value, usual = slow @ found[:100, :100] @ slow, 2.0
    assert found_value < 0.05 * usual  # 0.001 if it were known; a taper of 0.6 s leaves 0.3
    assert np.diag(found) == pytest.approx(np.full(200, usual), rel=0.4, abs=0.1)
    assert found[10:90, 111:191].diagonal() == pytest.approx(np.full(80, usual), rel=0.4)
