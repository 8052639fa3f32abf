"""The standard deviation of white noise, whatever course it lies on."""

import numpy as np
import pytest

from hannes.core.recording.white_noise import roughness


def test_noise_is_separated_from_the_course_and_from_rare_jumps():
    rng, count = np.random.default_rng(1), np.arange(20_000)
    noise = 0.02 * rng.standard_normal(count.size)
    jumps = np.where(count % 1000 > 500, 5.0, 0.0)
    for course in (0.0, 3e-3 * count, np.sin(2e-3 * count), jumps):
        assert roughness(course + noise) == pytest.approx(0.02, rel=0.03)
    assert roughness(0.5 * count) == 0.0
