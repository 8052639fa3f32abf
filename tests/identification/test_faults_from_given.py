"""Faults of like parts start in the machine as given, too, where recordings inform much."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import as_given, effect_search, global_starts
from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.tuning import SEARCH

WITHOUT = 4000.0  # chi-squared, of the machine as given with all else following


def started(monkeypatch, **promises):
    """Names of the faults that are started, by the reduction that each promises."""
    monkeypatch.setattr(global_starts, "part_faults", lambda *_: list(promises))
    monkeypatch.setattr(global_starts, "_without", lambda nominal: WITHOUT)
    monkeypatch.setattr(
        global_starts,
        "looked_at_sizes",
        lambda nominal, name, sizes: (None, np.array([WITHOUT + 50.0, WITHOUT - promises[name]])),
    )
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


@pytest.mark.parametrize(
    ("gains", "leaves", "stands"), [(2.0, 0.9, True), (2.0, 1.1, False), (0.9, 0.9, False)]
)
def test_a_best_effect_that_explains_all_of_much_stands(monkeypatch, gains, leaves, stands):
    monkeypatch.setattr(effect_search, "stands", lambda *_: False)
    bins = np.zeros(1000)
    point = SimpleNamespace(chi2=leaves * SEARCH.explained * bins.size, residual=bins)
    best = SimpleNamespace(effects=("fault",), point=point, delta_chi2=gains * SEARCH.sure_beside)
    baseline = SimpleNamespace(chi2=point.chi2 + 200.0)
    found = SimpleNamespace(baseline=baseline, trials=[best])
    assert effect_search._stands(found) is stands
