"""Small gains are judged beside a baseline that started in the machine as given."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import small_gains
from hannes.identification.diagnosis.small_gains import with_small_gains
from hannes.identification.diagnosis.trials import SearchResult, Trial

BINS = 1000


def point(chi2, moved=True):
    """A fit of a machine some of whose parts are off, or of one that is as stated."""
    model = SimpleNamespace(parts_at={"index": 1.0} if moved else {})
    return SimpleNamespace(chi2=chi2, residual=np.zeros(BINS), model=model)


def trial(gain, name, baseline=800.0):
    return Trial((name,), point(baseline - gain), gain)


def result(gains, baseline=800.0, moved=True):
    trials = [trial(gain, f"effect {k}", baseline) for k, gain in enumerate(gains)]
    here = point(baseline, moved)
    return SearchResult(here, here, [], trials, None, None, 1.0)


@pytest.fixture
def _judged(monkeypatch):
    """A baseline from the machine as given is lower by 30, and effects gain 2 beside it."""
    monkeypatch.setattr(small_gains, "_from_as_given", lambda at, factor: point(at.chi2 - 30.0))
    monkeypatch.setattr(small_gains, "differenced_about", lambda at, model: at)

    def beside(start, each):
        return Trial(each.effects, point(start.chi2 - 2.0), 0.0)

    def repriced(found, each):
        return Trial(each.effects, each.point, found.baseline.chi2 - each.point.chi2)

    monkeypatch.setattr(small_gains, "_beside", beside)
    monkeypatch.setattr(small_gains, "_repriced", repriced)


@pytest.mark.usefixtures("_judged")
def test_none_of_many_small_gains_stays_unjudged():
    found = with_small_gains(result([45.5, 45.4, 45.3, 45.2, 45.1]), lambda text: None)
    assert found.baseline.chi2 == 770.0
    assert max(each.delta_chi2 for each in found.trials) == pytest.approx(2.0)


@pytest.mark.usefixtures("_judged")
@pytest.mark.parametrize(
    "found",
    [
        result([13.0]),  # no name anyway
        result([90.0, 20.0]),  # one gains much
        result([40.0], baseline=1200.0),  # the baseline leaves more than noise
        result([40.0], moved=False),  # no part can be off
    ],
)
def test_other_results_stay(found):
    assert with_small_gains(found, lambda text: None) is found
