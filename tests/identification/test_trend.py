"""What changes from run to run."""

from sled import TURBULENCE, found

from hannes.identification.diagnosis.trend import strongest_trend
from hannes.identification.diagnosis.tuning import SEARCH


def test_a_trend_across_runs_is_no_clean_name():
    verdict = found(1, ((TURBULENCE, 0.02),), growth=1.0)
    assert verdict.verdict in ("unknown", "named_with_remainder")
    assert "from run to run" in verdict.reason


def test_what_does_not_grow_is_no_trend(investigated):
    best = investigated.trials[0].point
    assert strongest_trend(best, investigated.guesses).delta_chi2 < SEARCH.name_limit
    assert (
        strongest_trend(investigated.baseline, investigated.guesses).delta_chi2
        < 0.95 * investigated.trials[0].delta_chi2
    )
