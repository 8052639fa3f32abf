"""What a search leaves out where its work would bring little."""

from dataclasses import replace
from types import MappingProxyType, SimpleNamespace

import numpy as np
import pytest
from sled import HARDENING, TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import (
    as_given,
    better_baseline,
    effect_search,
    global_starts,
    multistart,
)
from hannes.identification.diagnosis import single_effects as single
from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.gauss_newton import settled
from hannes.identification.diagnosis.global_starts import worth_global_starts
from hannes.identification.diagnosis.linearisation import Linearisation
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded

BINS = 1000


def silent(text):
    """No progress."""


def left(per_bin, work=0.0):
    """A fit by what it leaves, of a machine by what a round of derivatives takes."""
    model = SimpleNamespace(round_of_derivatives=lambda: work)
    made = SimpleNamespace(chi2=per_bin * BINS, residual=np.zeros(BINS), model=model)
    made.cheaply_derived = Linearisation.cheaply_derived.fget(made)
    return made


@pytest.fixture(scope="module")
def found():
    """The search of a sled with turbulence, one of two candidates."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    return search_effects(Sled(), entries, [TURBULENCE, HARDENING], Settings(0.02, 0.005), 0)


def test_global_starts_are_left_out_where_they_take_much_for_little():
    much = 2.0 * SEARCH.much_work
    assert worth_global_starts(left(1.0)) and worth_global_starts(left(1.2, much))
    assert not worth_global_starts(left(1.1, much))


def begun(found, monkeypatch, explained, elsewhere=MappingProxyType({})):
    """Effects with a fit, and whether anything started in the machine as given."""
    promising = replace(SEARCH, explained=explained, biased_baseline=np.inf)
    monkeypatch.setattr(single, "SEARCH", promising)
    given = AsGiven(found.nominal, found.baseline, ["turbulence", "hardening"])
    asked = []
    monkeypatch.setattr(given, "global_fits", lambda *_: asked.append("global") or elsewhere)
    fits, predicted = single._begun(found.baseline, given, found.guesses, {}, silent)
    assert set(fits) <= set(predicted)
    return fits, asked


def test_what_explains_all_leaves_nothing_to_start_in_the_machine_as_given(found, monkeypatch):
    best = found.trials[0].point
    per_bin = best.chi2 / best.residual.size
    fits, asked = begun(found, monkeypatch, 1.05 * per_bin)
    assert "turbulence" in fits and not asked
    fits, asked = begun(found, monkeypatch, 0.5 * per_bin)
    assert "turbulence" in fits and asked == ["global"]
    better = replace(best, residual=0.5 * best.residual)
    fits, _ = begun(found, monkeypatch, 0.5 * per_bin, {"turbulence": better})
    assert fits["turbulence"] is better


def test_a_global_start_is_followed_until_it_leaves_less_than_another(found):
    start = multistart.started_at(
        found.nominal, found.nominal.space.of("turbulence"), np.array([0.1])
    )
    whole = settled(start)
    once = global_starts.followed(start, 0.5 * (start.chi2 + whole.chi2))
    assert whole.chi2 < once.chi2 < start.chi2
    assert global_starts.followed(start, start.chi2 + 1.0) is start


def test_a_second_start_is_left_out_where_the_baseline_is_hardly_biased(found, monkeypatch):
    starts, start = [], multistart.started_at
    monkeypatch.setattr(multistart, "started_at", lambda *how: starts.append(1) or start(*how))
    point = found.trials[0].point
    given = (point, found.baseline, found.nominal, 1e9, np.inf)  # promised more than it reaches
    for slight, bound, expected in ((0.0, 0.0, 1), (np.inf, 0.0, 0), (0.0, 1.3, 0)):
        starts.clear()
        other = replace(SEARCH, slight=slight, biased_baseline=bound)
        monkeypatch.setattr(multistart, "SEARCH", other)
        multistart._from_both(*given)
        assert len(starts) == expected


def test_a_slight_improvement_asks_for_a_better_baseline_at_once(monkeypatch):
    asked = []
    monkeypatch.setattr(better_baseline, "estimated_variance_factor", lambda *_: 1.0)
    monkeypatch.setattr(better_baseline, "better_baseline", lambda *given: asked.append(given))
    baseline = left(1.0)
    for less in (5.0, 30.0, 70.0):
        fits = {"best": SimpleNamespace(chi2=baseline.chi2 - less)}
        led = better_baseline.led_by_little(baseline, fits, silent)
        assert led.better is None and led.by is (fits["best"] if less == 30.0 else None)
    assert [given[1].chi2 for given in asked] == [baseline.chi2 - 30.0]
    assert better_baseline.led_by_little(baseline, {}, silent).by is None


def test_of_many_bins_a_round_that_gains_little_is_the_last(found, monkeypatch):
    point = replace(found.trials[0].point, last_reduction=2.0)
    assert settled(point) is not point
    per_bin = replace(FIT, settled_per_bin=2.1 / point.residual.size)
    monkeypatch.setattr("hannes.identification.diagnosis.gauss_newton.FIT", per_bin)
    assert settled(point) is point


def test_much_is_explained_by_what_explains_all():
    baseline, little = left(5.0), replace(SEARCH).explained
    assert single.explains_all(baseline, left(0.9 * little))
    assert not single.explains_all(baseline, left(1.1 * little))
    assert not single.explains_all(left(0.9 * little + 0.05), left(0.9 * little))  # of 50 in all


def test_a_better_baseline_is_asked_for_once_from_the_same_fit(found, monkeypatch):
    asked = []
    monkeypatch.setattr(effect_search, "better_baseline", lambda *given: asked.append(given))
    given = AsGiven(found.nominal, found.baseline, [])
    best = found.trials[0].point
    for known, times in ((None, 1), (best, 0)):
        asked.clear()
        effect_search._beside_better(given, replace(found, asked=known), {}, silent)
        assert len(asked) == times


def test_global_fits_are_followed_below_a_better_baseline(found, monkeypatch):
    start = multistart.started_at(
        found.nominal, found.nominal.space.of("turbulence"), np.array([0.1])
    )
    monkeypatch.setattr(as_given, "global_fits", lambda *_: {"turbulence": start})
    given = AsGiven(found.nominal, found.baseline, ["turbulence"])
    high = replace(found.baseline, residual=10.0 * found.nominal.residual)
    assert given.global_fits(high, silent)["turbulence"] is start
    low = settled(start)
    between = SimpleNamespace(chi2=0.5 * (start.chi2 + low.chi2))
    assert given.global_fits(between, silent)["turbulence"].chi2 < between.chi2


def ended(*_):
    raise SearchEnded


def test_what_explains_all_stands_where_its_search_is_ended(found, monkeypatch):
    monkeypatch.setattr(single, "_further", ended)
    given = AsGiven(found.nominal, found.baseline, ["turbulence", "hardening"])
    with pytest.raises(SearchEnded):
        single.searched_beside(found.baseline, given, {}, silent)
    best = found.trials[0].point
    all_of_it = replace(
        SEARCH, biased_baseline=1.0, explained=1.05 * best.chi2 / best.residual.size
    )
    monkeypatch.setattr(single, "SEARCH", all_of_it)
    again = single.searched_beside(found.baseline, given, {}, silent)
    assert again.cut_short and again.trials[0].effects == ("turbulence",)
    assert effect_search._beside_better(given, again, {}, silent) is again


def test_a_fault_of_one_of_like_parts_does_not_stand_alone(found, monkeypatch):
    best = found.trials[0].point
    all_of_it = replace(SEARCH, explained=1.05 * best.chi2 / best.residual.size)
    monkeypatch.setattr(single, "SEARCH", all_of_it)
    assert single.stands(found.baseline, {"turbulence": best})
    assert not single.stands(found.baseline, {})
    monkeypatch.setattr(single, "like_faults", lambda effects, name: ["another"])
    assert not single.stands(found.baseline, {"turbulence": best})


def test_a_second_search_that_was_cut_short_is_the_last(found, monkeypatch):
    short, asked = replace(found, cut_short=True), []
    better = replace(found.baseline, residual=0.5 * found.baseline.residual)
    monkeypatch.setattr(effect_search, "better_baseline", lambda *_: asked.append(1) or better)
    monkeypatch.setattr(effect_search, "searched_beside", lambda *_: short)
    given = AsGiven(found.nominal, found.baseline, [])
    assert effect_search._beside_better(given, found, {}, silent) is short
    assert len(asked) == 1
