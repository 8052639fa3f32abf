"""What repeats of a residual are stated: presence, absence, or too few runs to decide."""

import numpy as np
import pytest

from hannes.identification.calibration.repeatable_residual import (
    RepeatableResidual,
    _beside_spread,
    _largest_hidden,
)
from hannes.identification.calibration.tuning import CALIBRATION


@pytest.mark.parametrize(("groups", "runs"), [(1, 3), (3, 5), (4, 10)])
def test_what_may_hide_shows_in_nineteen_campaigns_of_twenty(groups, runs):
    rng = np.random.default_rng(groups)
    hidden = _largest_hidden(1.0, groups, groups * (runs - 1))
    shift = hidden / np.sqrt(runs)  # the same in every run, runs differ by 1
    drawn = shift + rng.standard_normal((4000, groups, runs))
    means = runs * (drawn.mean(axis=2) ** 2).mean(axis=1)
    ratios = np.sqrt(means / drawn.var(axis=2, ddof=1).mean(axis=1))
    assert _beside_spread([x[:, np.newaxis] for x in drawn[0]])[0] == pytest.approx(ratios[0])
    assert np.mean(ratios <= 1.0) == pytest.approx(0.05, abs=0.012)


def test_few_runs_hide_more_than_many():
    few, many = (_largest_hidden(1.0, 2, 2 * (runs - 1)) for runs in (2, 10))
    assert few > CALIBRATION.absent_ratio >= _largest_hidden(1.0, 4, 4 * 9) and few > many


def test_absence_comes_with_what_would_have_shown():
    absent = RepeatableResidual(False, 0.6, 0.1, {}, 1e-3, 1.0, 1.7)
    open_ = RepeatableResidual(None, 0.6, 0.1, {}, 0.25, 1.0, 2.7)
    assert "does not repeat" in absent.sentence and "1.7 times" in absent.sentence
    assert "Too few runs" in open_.sentence and "2.7 times" in open_.sentence
