"""Faults of like parts start in the machine as given, too, where recordings inform much."""

from types import SimpleNamespace

import pytest

from hannes.identification.diagnosis import as_given, effect_search, global_starts
from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded

WITHOUT = 4000.0  # chi-squared, of the machine as given with all else following


def started(monkeypatch, **promises):
    """Names of the faults that are started, by the reduction that each promises."""
    monkeypatch.setattr(global_starts, "part_faults", lambda *_: list(promises))
    monkeypatch.setattr(global_starts, "_without", lambda nominal: WITHOUT)
    left = {name: WITHOUT - promise for name, promise in promises.items()}
    monkeypatch.setattr(global_starts, "_least", lambda nominal, faults, *_: left)
    monkeypatch.setattr(global_starts, "_while_near", lambda _n, _b, some, *_: some)
    nominal = SimpleNamespace(space=SimpleNamespace(effects={}))
    found = global_starts.faults_from_given(nominal, None, list(promises), lambda text: None)
    return list(found)


def test_the_likeliest_start_and_no_others(monkeypatch):
    assert started(monkeypatch, a=250.0, b=500.0, c=400.0, d=450.0) == ["b", "d"]
    assert started(monkeypatch, a=250.0, b=500.0) == ["b"]


def test_what_hardly_biases_a_baseline_is_not_started(monkeypatch):
    assert started(monkeypatch, a=0.9 * SEARCH.slight, b=10.0) == []
    assert started(monkeypatch) == []


@pytest.mark.parametrize(("worth", "asked"), [(True, "all"), (False, "faults")])
def test_faults_alone_are_asked_where_all_effects_take_too_much(monkeypatch, worth, asked):
    point = SimpleNamespace(chi2=1.0)
    monkeypatch.setattr(as_given, "worth_global_starts", lambda baseline: worth)
    monkeypatch.setattr(as_given, "promised", lambda *_: None)
    monkeypatch.setattr(as_given, "global_fits", lambda *_: {"all": point})
    monkeypatch.setattr(as_given, "faults_from_given", lambda *_: {"faults": point})
    baseline = SimpleNamespace(chi2=2.0)
    assert list(AsGiven(None, baseline, []).global_fits(baseline, print)) == [asked]


def result(named):
    """A search whose best effect may be named, or not."""
    best = SimpleNamespace(effects=("fault",), point=None)
    return SimpleNamespace(baseline=None, trials=[best], variance_factor=1.0, named=named)


@pytest.mark.parametrize("better", [None, "another"])
def test_a_baseline_that_was_not_asked_for_is_asked_once_more(monkeypatch, better):
    """What stands beside it is named; where nothing does, nothing is."""
    found, beside = result(True), {None: None, "another": result(True)}
    monkeypatch.setattr(effect_search, "better_baseline", lambda *_: better)
    monkeypatch.setattr(effect_search, "_rebased", lambda found, better: beside[better])
    monkeypatch.setattr(effect_search, "may_be_named", lambda each: each.named)
    again = effect_search._asked_again(found, print)
    assert again is (found if better is None else beside[better])
    beside["another"] = result(False)
    if better:
        with pytest.raises(SearchEnded):
            effect_search._asked_again(found, print)
