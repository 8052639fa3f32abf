"""Small gains are judged beside a baseline that started in the machine as given."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import small_gains
from hannes.identification.diagnosis.small_gains import with_small_gains
from hannes.identification.diagnosis.trials import SearchResult, Trial
from hannes.identification.diagnosis.work_bound import SearchEnded

BINS = 1000


def point(chi2, moved=True, value=0.0):
    """A fit of a machine some of whose parts are off, or of one that is as stated."""
    model = SimpleNamespace(parts_at={"index": 1.0} if moved else {})
    known = {"space": SimpleNamespace(uncertain=np.array([0])), "x": np.array([value])}
    return SimpleNamespace(chi2=chi2, residual=np.zeros(BINS), model=model, noise=None, **known)


def trial(gain, name, baseline=800.0):
    return Trial((name,), point(baseline - gain, value=1.0), gain)


def result(gains, baseline=800.0, moved=True):
    trials = [trial(gain, f"effect {k}", baseline) for k, gain in enumerate(gains)]
    here = point(baseline, moved)
    return SearchResult(here, here, [], trials, None, None, 1.0)


def lower_from(monkeypatch, *values):
    """A baseline is lower by 30 where it starts from one of these values of the machine."""

    def started(at, start, factor):
        return point(at.chi2 - 30.0) if float(start[0]) in values else None

    monkeypatch.setattr(small_gains, "_from_no_parts", started)


@pytest.fixture
def _judged(monkeypatch):
    """A baseline from the machine as given is lower by 30, and effects gain 2 beside it."""
    lower_from(monkeypatch, 0.0)
    monkeypatch.setattr(small_gains, "about", lambda at, noise: at)

    def beside(found, each):
        own = {"real": 60.0, "rival": 58.0}.get(each.effects[0], 2.0)
        return Trial(each.effects, point(found.baseline.chi2 - own, value=1.0), 0.0)

    def repriced(found, each):
        return Trial(each.effects, each.point, found.baseline.chi2 - each.point.chi2)

    monkeypatch.setattr(small_gains, "_beside", beside)
    monkeypatch.setattr(small_gains, "near", lambda best, others: [])
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


@pytest.mark.usefixtures("_judged")
def test_rivals_of_the_best_effect_are_judged_with_it(monkeypatch):
    found = result([60.0, 58.0])
    names = ("real", "rival")
    trials = [replace(each, effects=(n,)) for each, n in zip(found.trials, names, strict=True)]
    monkeypatch.setattr(small_gains, "near", lambda best, others: others[1:])
    again = with_small_gains(replace(found, trials=trials), lambda text: None)
    assert [(each.effects[0], each.delta_chi2) for each in again.trials] == [
        ("real", 60.0), ("rival", 58.0),
    ]  # fmt: skip


@pytest.mark.usefixtures("_judged")
def test_where_the_bound_of_work_ends_it_gains_are_those_beside_the_lower_baseline(monkeypatch):
    def ended(found, each):
        raise SearchEnded

    monkeypatch.setattr(small_gains, "_beside", ended)
    found = with_small_gains(result([40.0]), lambda text: None)
    assert found.trials[0].delta_chi2 == pytest.approx(10.0)


@pytest.mark.usefixtures("_judged")
@pytest.mark.parametrize(("values", "chi2"), [((1.0,), 770.0), ((0.0, 1.0), 770.0)])
def test_a_baseline_is_asked_for_where_the_best_effect_led(monkeypatch, values, chi2):
    """Not where nothing gains beside the one from the machine as given."""
    lower_from(monkeypatch, *values)
    found = with_small_gains(result([40.0]), lambda text: None)
    assert (found.baseline.chi2, found.trials[0].delta_chi2) == (chi2, pytest.approx(10.0))


@pytest.mark.usefixtures("_judged")
def test_what_was_judged_stands_where_the_bound_ends_the_next_baseline(monkeypatch):
    def started(at, start, factor):
        if start.any():
            raise SearchEnded
        return point(at.chi2 - 30.0)

    monkeypatch.setattr(small_gains, "_from_no_parts", started)
    found = result([70.0])
    found = replace(found, trials=[replace(each, effects=("real",)) for each in found.trials])
    again = with_small_gains(found, lambda text: None)
    assert (again.baseline.chi2, again.trials[0].delta_chi2) == (770.0, pytest.approx(60.0))


def test_an_effect_is_refitted_from_where_it_leaves_least(monkeypatch):
    fits = iter([point(790.0), point(780.0)])
    monkeypatch.setattr(small_gains, "started_at", lambda *given: point(0.0))
    monkeypatch.setattr(small_gains, "about", lambda *given: point(0.0))
    monkeypatch.setattr(small_gains, "fitted", lambda at, steps: next(fits))
    monkeypatch.setattr(small_gains, "with_correction_at_size", lambda at, name: at)
    asked = []
    monkeypatch.setattr(
        small_gains, "with_parts_as_fitted", lambda at, factor: asked.append(factor)
    )
    one = trial(20.0, "effect")
    one.point.space = SimpleNamespace(of=lambda *names: np.array([0]))
    one.point.x = np.zeros(1)
    found = SimpleNamespace(baseline=point(800.0), variance_factor=1.05)
    assert small_gains._beside(found, one).point.chi2 == 780.0  # its parts cannot be moved
    assert asked == [1.05]
