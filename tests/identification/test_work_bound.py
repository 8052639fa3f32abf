"""The number of simulations is bounded, said before, and kept."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import HARDENING, Described, Sled, campaign

from hannes.identification.diagnosis import (
    campaign_diagnosis,
    effect_search,
    final_fit,
    observed_controller,
    untested,
    work_bound,
)
from hannes.identification.diagnosis.campaign_diagnosis import diagnose_campaign
from hannes.identification.diagnosis.foretold import command_durations, foretold
from hannes.identification.diagnosis.observed_controller import Apart, _nearer, _said
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.shape import likeliest
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded, Work, as_single, ordinary_time
from hannes.plants.hand.plant import HandPlant


def ended(*_):
    raise SearchEnded


def spent(monkeypatch, limit):
    """What a diagnosis of a sled simulates, what it said that at most, and its verdict."""
    monkeypatch.setattr(work_bound, "SEARCH", replace(work_bound.SEARCH, most_simulated=limit))
    whole, said = [], []

    class Counted(Work):
        def add(self, runs, duration, exact):
            super().add(runs, duration, exact)
            whole.append(runs * duration)

    monkeypatch.setattr(campaign_diagnosis, "Work", Counted)
    made = campaign(1, ((HARDENING, 900.0),))
    found = diagnose_campaign(made, Settings(0.02, 0.005), 0, said.append)
    durations = command_durations(made)
    bound = Counted(True).most(durations, len(Sled.uncertain))
    count = bound / (sum(durations) / len(durations))
    assert said[0].startswith(f"at most as much as {count:,.0f} single simulations")
    return sum(whole), bound, found.verdict


def test_a_plant_that_is_slow_is_said_to_be(monkeypatch):
    """Twelve thousand simulations are a moment of a compiled plant, and hours of another."""
    made, clock = campaign(1, ()), iter(np.arange(0.0, 1.0, 0.06))
    monkeypatch.setattr("time.process_time", lambda: next(clock))
    text = foretold(made, Work(True), len(Sled.uncertain))
    assert ": one takes 60 ms here, all up to " in text and text.endswith(" min")
    monkeypatch.setattr(Sled, "many", None, raising=False)  # it makes them side by side
    assert "takes" not in foretold(made, Work(True), len(Sled.uncertain))


@pytest.mark.parametrize("limit", [1.0, 40.0, 30_000.0])
def test_all_stages_together_keep_the_bound_that_was_said(monkeypatch, limit):
    made, bound, verdict = spent(monkeypatch, limit)
    assert made <= bound
    at_bound = "the search was ended at its bound" in verdict.reason
    assert at_bound == (limit < 30_000.0)
    assert verdict.verdict == ("unknown" if at_bound else "named")


def test_the_shape_of_an_unknown_is_within_the_bound_that_was_said(monkeypatch):
    whole = []

    class Counted(Work):
        def __init__(self, bounded=False, times=1):
            super().__init__(bounded, times)
            whole.append(self)

    for module in (campaign_diagnosis, likeliest):
        monkeypatch.setattr(module, "Work", Counted)
    monkeypatch.setattr(campaign_diagnosis, "candidates", lambda made: {})
    made = replace(campaign(1, ((HARDENING, 900.0),)), plant=Described())
    found = diagnose_campaign(made, Settings(0.02, 0.005), 0, lambda text: None)
    search, shape = whole
    assert found.verdict.verdict == "unknown" and shape.spent > 0.0
    assert search.limit + shape.limit <= search.most([], 0)


def test_a_user_lets_a_search_last_longer(monkeypatch):
    monkeypatch.setattr(work_bound, "SEARCH", replace(work_bound.SEARCH, most_simulated=40.0))
    made = campaign(1, ((HARDENING, 900.0),))
    verdicts = [
        diagnose_campaign(made, Settings(0.02, 0.005, work=times), 0, lambda text: None).verdict
        for times in (1, 2, 50)
    ]
    assert [each.verdict for each in verdicts] == ["unknown", "unknown", "named"]
    assert "40 s of single runs" in verdicts[0].reason and "work = 2 in" in verdicts[0].reason
    assert "80 s of single runs" in verdicts[1].reason and "work = 4 in" in verdicts[1].reason


def test_the_shape_of_what_is_missing_is_fitted_where_a_search_was_ended(monkeypatch):
    monkeypatch.setattr(work_bound, "SEARCH", replace(work_bound.SEARCH, most_simulated=40.0))
    made = replace(campaign(1, ((HARDENING, 900.0),)), plant=Described())
    found = diagnose_campaign(made, Settings(0.02, 0.005), 0, lambda text: None)
    assert "ended at its bound" in found.verdict.reason
    assert found.verdict.shape["name"] == "generic_force"


def test_what_is_needed_in_any_case_is_counted_and_made():
    work = Work(bounded=True)
    work.spent = work.limit
    with pytest.raises(SearchEnded):
        work.add(1, 1.0, False)
    with work.in_any_case():
        work.add(1, 1.0, True)
    assert work.bounded and work.spent > work.limit


def test_runs_that_took_more_than_ordinary_ones_count_by_what_they_took():
    class Made(list):
        work = 7.0

    work = Work(bounded=True)
    counted = work.add(2, 1.0, False)
    assert work.taken([None, None], counted) == [None, None] and work.spent == 2.0
    work.taken(Made([None, None]), counted)
    assert work.spent == 7.0


def test_runs_side_by_side_count_less_than_single_ones():
    class Made(list):
        work = 90.0

    work = Work(bounded=True)
    counted = work.add(as_single(60), 1.0, False)
    assert 60 * SEARCH.alike_weight < counted < 30.0
    work.taken(Made([None] * 60), counted, SEARCH.alike_weight)  # as if half as many more
    assert work.spent == pytest.approx(90.0 * SEARCH.alike_weight)


def test_a_slow_command_counts_no_more_than_the_longest_that_counts():
    assert ordinary_time(HandPlant(), 1.2) == 1.2
    assert ordinary_time(HandPlant(), 7.0) == HandPlant.longest_counted < 7.0
    assert ordinary_time(Sled(), 7.0) == 7.0  # it says nothing of that


def test_a_single_effect_stands_with_a_remainder_where_the_search_beside_it_is_ended(monkeypatch):
    monkeypatch.setattr(effect_search, "with_further_effects", ended)
    found = diagnose_campaign(campaign(1, ((HARDENING, 900.0),)), Settings(0.02, 0.005), 0, silent)
    assert found.verdict.verdict == "named_with_remainder"
    assert "search for further effects was ended" in found.verdict.reason


def test_an_effect_stands_beside_a_better_baseline_where_its_second_search_is_ended(monkeypatch):
    made, searches = effect_search.searched_beside, []

    def searched(*given):
        searches.append(given)
        return made(*given) if len(searches) == 1 else ended()

    def better(baseline, *_):
        return replace(baseline, residual=baseline.residual * 0.9)

    monkeypatch.setattr(effect_search, "searched_beside", searched)
    monkeypatch.setattr(effect_search, "better_baseline", better)
    found = diagnose_campaign(campaign(1, ((HARDENING, 900.0),)), Settings(0.02, 0.005), 0, silent)
    assert len(searches) == 2 and found.found.baseline is not searches[0][0]
    assert found.verdict.verdict == "named_with_remainder"


def test_without_a_better_baseline_nothing_stands(monkeypatch):
    monkeypatch.setattr(effect_search, "better_baseline", ended)
    found = diagnose_campaign(campaign(1, ((HARDENING, 900.0),)), Settings(0.02, 0.005), 0, silent)
    assert found.verdict.verdict == "unknown"
    assert "the search was ended at its bound" in found.verdict.reason


def test_sizes_are_those_of_the_search_where_the_final_fit_does_not_end(monkeypatch):
    monkeypatch.setattr(final_fit, "begun", ended)
    found = diagnose_campaign(campaign(1, ((HARDENING, 900.0),)), Settings(0.02, 0.005), 0, silent)
    assert found.verdict.verdict == "named"
    assert "its sizes may be coarse" in found.verdict.reason
    (size,) = found.verdict.parameters.values()
    assert size["low"] < 900.0 < size["high"]


def test_what_closes_a_search_and_its_rivals_have_work_of_their_own_once():
    work = Work(bounded=True)
    before = work.limit
    for _ in range(2):
        work.extended_for_rivals()
        assert work.limit == before + SEARCH.rivals_simulated
    for _ in range(2):
        work.extended()
        more = SEARCH.rivals_simulated + SEARCH.closing_simulated
        assert work.limit == before + more


def silent(text):
    """No progress."""


def test_a_controller_beyond_the_bound_is_left_as_stated_and_said(monkeypatch):
    monkeypatch.setattr(observed_controller, "_sampled", lambda campaign: iter([None]))
    monkeypatch.setattr(observed_controller, "_apart", ended)
    made = campaign(1, ())
    found, said = observed_controller.as_recorded(made, Settings(), 0, lambda text: None)
    assert found is made and "not tested" in said


def test_the_controllers_sentence_says_what_decided():
    assert "comes 5.2 times as near: that is taken" in _said(1e-3, 5.2, True)
    counts = _said(1e-3, 0.9, True)
    assert "whole encoder counts, which firmware reads" in counts and "would not" in counts
    assert "cannot be simulated" in _said(1e-3, np.inf, False)


def group(bins=100, count=4):
    return SimpleNamespace(bins=bins, count=count, numbers=np.arange(count))


@pytest.mark.parametrize(
    ("groups", "simulated", "said"),
    [
        ([group(), group(bins=20)], True, "of 1 of 2 commands follow each other was not tested"),
        ([group(bins=20)], False, "repeats alone"),
        ([group(count=1)], False, "no command was repeated"),
        ([group(count=2)], True, "a change from run to run could not show"),
    ],
)
def test_what_could_not_have_fired_is_said_of_what_it_holds(groups, simulated, said):
    noise = SimpleNamespace(simulated_noise=simulated)
    baseline = SimpleNamespace(model=SimpleNamespace(groups=groups), noise=noise)
    found = untested.untested(SimpleNamespace(baseline=baseline, guesses=[1]), "recalibrated")
    assert any(said in each for each in found)


@pytest.mark.parametrize(
    ("distance", "deviance", "counted", "taken"),
    [
        (0.85, 9.0, False, True),  # nearer
        (1.2, 9.0, False, False),  # farther: how far the machine is off does not decide alone
        (1.2, 50.0, True, True),  # firmware's whole counts, about as near
        (2.1, 50.0, True, False),  # the continuous one is as near as a right one
        (2.1, 9.0, True, True),  # whole counts, and a machine much nearer to its values
        (4.5, 9.0, True, False),  # too far
    ],
)
def test_a_sampled_controller_is_taken_where_it_or_its_machine_is_nearer(
    distance, deviance, counted, taken
):
    assert _nearer(Apart(distance, deviance), Apart(1.0, 40.0), counted, 1.1) is taken


def test_whole_counts_speak_for_firmware_where_the_continuous_controller_is_not_near_either():
    """Something large is missing: which of both is nearer then is chance."""
    assert _nearer(Apart(2.1, 50.0), Apart(1.0, 40.0), True, 0.6)
    assert not _nearer(Apart(2.1, 50.0), Apart(1.0, 40.0), False, 0.6)
    assert not _nearer(Apart(4.5, 50.0), Apart(1.0, 40.0), True, 0.6)


def test_what_a_right_controller_leaves_depends_on_how_many_repeats_there_are(monkeypatch):
    monkeypatch.setattr(observed_controller, "grouped", lambda plant, entries: [entries])
    left = []
    for count in (1, 4, 25):
        entries = [SimpleNamespace(role="fit")] * count
        left.append(observed_controller._near(SimpleNamespace(plant=None, entries=entries)))
    assert left[0] > 1.3 and 0.7 < left[1] < 0.72 and left[2] < 0.4
