"""Medians by comparisons against the filter that sorts every window."""

import numpy as np
import pytest
from scipy.ndimage import median_filter

from hannes.core.recording.median_of_few import median_of_five, median_of_three


@pytest.mark.parametrize(("median", "size"), [(median_of_three, 3), (median_of_five, 5)])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6, 500])
def test_the_same_as_sorting_every_window(median, size, count):
    rng = np.random.default_rng(count)
    for values in (rng.normal(size=count), rng.integers(0, 3, count).astype(float)):
        assert np.array_equal(median(values), median_filter(values, size, mode="nearest"))
