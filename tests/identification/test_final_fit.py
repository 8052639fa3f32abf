"""How large what was named is, and how surely: finer bins, and the floor of a kinked valley."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import KNOWN, TIMES, TURBULENCE, Sled, recordings

from hannes.core.errors import ComputationFailed
from hannes.identification.diagnosis import final_fit as module
from hannes.identification.diagnosis import profile_likelihood as profiles
from hannes.identification.diagnosis.baseline import FINE
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.final_fit import final_fit
from hannes.identification.diagnosis.gauss_newton import standard_deviations
from hannes.identification.diagnosis.profile_likelihood import Profile, profile
from hannes.identification.diagnosis.repeat_groups import Group
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import NOTHING, Model
from hannes.identification.diagnosis.tuning import FIT
from hannes.identification.diagnosis.work_bound import SearchEnded

SIZE = 2.0  # N s^2/m^2
NAME = ["turbulence"]


@pytest.fixture(scope="module")
def named():
    """The fit with the effect that is hidden."""
    entries = [each for each in recordings(1, ((TURBULENCE, SIZE),)) if each.role != "show"]
    found = search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)
    return found.trials[0].point


def of(point, name="turbulence"):
    """Place of an effect's size, its row among the active directions, and what a step is."""
    space = point.space
    place = int(space.of(name)[0])
    return place, int(np.searchsorted(point.active, place)), space.parameters[place].scale


def test_groups_have_so_many_times_as_many_bins(named):
    for group in named.model.groups:
        narrow, interval = Group(Sled(), group.entries, FIT.finer_bins), np.diff(TIMES)[0]
        wanted = group.width / FIT.finer_bins
        assert wanted - 1e-9 <= narrow.width < wanted + interval  # of whole samples
        assert narrow.bins == pytest.approx(TIMES[-1] / narrow.width, abs=1)


def test_effects_are_part_of_a_machine_that_holds_them(named):
    model = named.model
    held, rows = model.held(model.groups), named.x[np.newaxis]
    for group in model.groups:
        without, with_effect = (model.vectors(group, rows, each) for each in (False, True))
        assert np.array_equal(held.vectors(group, rows, False), with_effect)
        assert np.abs(with_effect - without).max() > 1e-3
        moved = rows + 0.1 * (np.arange(rows.size) == 0)
        changes = held.changes(group, named.x, moved, False)
        assert np.array_equal(changes, model.changes(group, named.x, moved, True))


def test_a_named_effect_is_known_better_in_finer_bins(named):
    found = final_fit(named, NAME, FINE, 0)
    place, row, scale = of(named)
    coarse, narrow = standard_deviations(named)[row], found.deviations[place]
    assert narrow < 0.9 * coarse
    assert abs(found.point.x[place] * scale - SIZE) < 3.0 * narrow * scale
    others = set(named.active.tolist()) - {place}
    assert set(found.deviations) == {place, *others}
    assert found.point.active.tolist() == sorted(others)  # that one is held where it is least


def stays(found, point):
    """Whether a fit is unchanged, with linear standard deviations."""
    linear = [FIT.linear_widening * each for each in standard_deviations(point)]
    return found.point is point and list(found.deviations.values()) == linear


def test_where_finer_bins_cannot_be_simulated_the_fit_stays(named, monkeypatch):
    def broken(*_):
        raise ComputationFailed("not here")

    monkeypatch.setattr(module, "begun", broken)
    assert stays(final_fit(named, NAME, FINE, 0), named)


def test_a_place_that_the_whole_firmware_cannot_run_is_not_taken(named, monkeypatch):
    simulated = Model.simulated

    def some(self, group, rows, effects, exact=False, further=NOTHING):
        broken = exact and self.groups[0] is not named.model.groups[0] and len(rows) == 1
        return [None] if broken else simulated(self, group, rows, effects, exact, further)

    monkeypatch.setattr(Model, "simulated", some)
    assert stays(final_fit(named, NAME, FINE, 0), named)


def test_what_is_least_along_each_but_not_along_all_is_not_taken(named, monkeypatch):
    place, *_ = of(named)

    def high(point, where, deviation):
        return Profile(point.x[where] + 40.0 * deviation, deviation, point)

    monkeypatch.setattr(module, "profile", high)
    found = final_fit(named, NAME, FINE, 0)
    assert abs(found.point.x[place] - named.x[place]) < 3.0 * found.deviations[place]
    assert place in found.point.active  # the fit in finer bins, free


def test_a_fit_in_finer_bins_stands_where_the_bound_of_work_ends_its_profiles(named, monkeypatch):
    def ended(*_):
        raise SearchEnded

    whole, (place, *_) = final_fit(named, NAME, FINE, 0), of(named)
    monkeypatch.setattr(module, "held_at", ended)
    profiled = final_fit(named, NAME, FINE, 0)
    monkeypatch.setattr(module, "profile", ended)
    fitted_finer = final_fit(named, NAME, FINE, 0)
    assert [each.cut_short for each in (whole, profiled, fitted_finer)] == [False, True, True]
    assert profiled.deviations[place] == whole.deviations[place]
    for found in (profiled, fitted_finer):
        assert found.point.residual.size > named.residual.size
        assert found.point.x[place] == pytest.approx(whole.point.x[place], abs=0.02)


def test_a_fit_in_finer_bins_goes_as_far_as_the_bound_of_work_lets_it(named, monkeypatch):
    def ended_after_one(point):
        yield moved
        raise SearchEnded

    moved = named.moved(named.x, named.active)
    monkeypatch.setattr(module, "rounds", ended_after_one)
    assert module._settled_while_allowed(named) == (moved, True)


def test_a_smooth_valley_has_the_linear_minimum_and_width(named):
    fine, _ = module._finer(named, NAME, FINE, 0)
    place, row, _ = of(fine)
    found = profile(fine, place, standard_deviations(fine)[row])
    assert abs(found.least - fine.x[place]) < 0.3 * found.deviation
    assert found.deviation == pytest.approx(standard_deviations(fine)[row], rel=0.15)


def valley(monkeypatch, chi2, at, deviation=0.1, low=-10.0):
    """The profile of a made-up misfit over one direction, walked from a place."""

    def held(point, places, values, below):
        there = SimpleNamespace(x=np.array(values), chi2=chi2(values[0]), space=space)
        return there if np.isfinite(there.chi2) else None

    space = SimpleNamespace(low=np.array([low]), high=np.array([10.0]))
    monkeypatch.setattr(profiles, "held_at", held)
    point = SimpleNamespace(x=np.array([at]), chi2=chi2(at), space=space)
    return profile(point, 0, deviation)


def test_a_place_that_is_far_above_is_given_up(named, monkeypatch):
    """A step of a profile that leads too far is not followed to the end."""
    monkeypatch.setattr(profiles, "FIT", replace(FIT, foreseen=0.0))
    asked, settled = [], profiles.settled
    monkeypatch.setattr(
        profiles, "settled", lambda at, *how: asked.append(how[1]) or settled(at, *how)
    )
    fine, _ = module._finer(named, NAME, FINE, 0)
    place, row, _ = of(fine)
    profile(fine, place, standard_deviations(fine)[row])
    assert asked and all(each < fine.chi2 + FIT.other_valley + 1e-9 for each in asked)


def test_a_fit_of_a_profile_that_foresees_no_reduction_takes_no_new_derivatives(named, monkeypatch):
    monkeypatch.setattr(profiles, "FIT", replace(FIT, foreseen=np.inf))
    monkeypatch.setattr(profiles, "settled", None)
    fine, _ = module._finer(named, NAME, FINE, 0)
    place, row, _ = of(fine)
    found = profile(fine, place, standard_deviations(fine)[row])
    assert found.deviation == pytest.approx(standard_deviations(fine)[row], rel=0.15)


def test_of_a_kinked_valley_the_minimum_is_found_from_a_local_one(monkeypatch):
    """As wide as 0.5, with local minima 0.3 apart that are 0.1 wide."""
    found = valley(
        monkeypatch, lambda x: ((x - 1.0) / 0.5) ** 2 + 2.0 * np.sin(10.0 * x) ** 2, 1.57
    )
    assert found.least == pytest.approx(1.0, abs=0.25)
    assert found.deviation == pytest.approx(0.5, rel=0.4)
    assert found.lowest.chi2 < 1.0


@pytest.mark.parametrize("width", [0.05, 0.02, 0.005])
def test_a_valley_narrower_than_linear_is_seen(monkeypatch, width):
    found = valley(monkeypatch, lambda x: (x / width) ** 2, 0.0)
    assert found.least == pytest.approx(0.0, abs=1e-9)
    assert found.deviation == pytest.approx(width, rel=1e-6)


def test_another_valley_does_not_count(monkeypatch):
    def two(x):
        return (x / 0.1) ** 2 if x < 0.2 else 80.0 + x

    found = valley(monkeypatch, two, 0.0)
    assert found.least == pytest.approx(0.0, abs=1e-9)
    assert found.deviation == pytest.approx(0.1, rel=1e-6)


SEEN_FROM_ONE_SIDE = {
    "no floor": (lambda x: -abs(x), -10.0),
    "breaks down beside it": (lambda x: 0.0 if x == 0.0 else np.nan, -10.0),
    "breaks down on one side": (lambda x: 20.0 * x + 5.0 * x**2 if x >= 0.0 else np.nan, -10.0),
    "at an end of the range": (lambda x: 20.0 * x + 5.0 * x**2, 0.0),
}


@pytest.mark.parametrize("case", SEEN_FROM_ONE_SIDE)
def test_what_is_not_seen_from_both_sides_is_no_valley(monkeypatch, case):
    chi2, low = SEEN_FROM_ONE_SIDE[case]
    assert valley(monkeypatch, chi2, 0.0, low=low) is None


def test_the_floor_is_where_it_was_walked(monkeypatch):
    """A flank that is nearly straight extrapolates to a distant minimum."""
    found = valley(monkeypatch, lambda x: 20.0 * x + x**2 if x > -0.03 else np.nan, 0.0)
    assert found is None or -0.03 <= found.least
    near = valley(monkeypatch, lambda x: ((x + 0.05) / 0.1) ** 2, 0.0, low=-0.03)
    assert near.least == -0.03
