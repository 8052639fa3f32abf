"""Fits of the baseline and of effects beside it: derivatives, starts, and what is left out."""

from dataclasses import replace

import numpy as np
import pytest
from sled import HARDENING, STIFFER, TURBULENCE, TWIN, Sled, recordings

from hannes.identification.diagnosis import (
    effect_removal,
    forward_selection,
    further_effects,
    gauss_newton,
    multistart,
)
from hannes.identification.diagnosis.better_baseline import better_baseline
from hannes.identification.diagnosis.effect_search import _rebased, search_effects
from hannes.identification.diagnosis.forward_selection import _refuted
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.multistart import _crossed, faded, started_at, without
from hannes.identification.diagnosis.score_test import Guess
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Trial
from hannes.identification.diagnosis.tuning import SEARCH


def test_derivatives_are_those_of_the_simulation(investigated):
    baseline = investigated.baseline
    model, x = baseline.model, baseline.x
    vectors, derivatives = differenced(model, x, baseline.active, False)
    moved = x.copy()
    moved[0] += 0.1
    for group, vector, slope in zip(model.groups, vectors, derivatives, strict=True):
        there = model.vectors(group, moved[np.newaxis], False)[0]
        moves = 0.1 * slope[0]
        assert there - vector == pytest.approx(moves, abs=0.03 * np.abs(moves).max())


def test_the_baseline_has_zero_gradient(investigated):
    baseline = investigated.baseline
    step = np.linalg.solve(baseline.hessian, baseline.gradient)
    assert step @ baseline.hessian @ step < 0.5
    assert baseline.chi2 > 1.5 * baseline.residual.size  # an effect is missing
    assert investigated.trials[0].point.chi2 < 1.2 * baseline.residual.size


def test_a_baseline_beside_its_minimum_is_led_back_by_an_effect(investigated):
    baseline = investigated.baseline
    beside = baseline.moved(
        baseline.x + 3.0 * np.isin(np.arange(baseline.x.size), baseline.active), baseline.active
    )
    assert beside.chi2 > baseline.chi2 + 20.0
    best, unit = investigated.trials[0], investigated.variance_factor
    asked = (best.point, best.effects, unit, lambda text: None)
    back = better_baseline(beside, *asked)
    assert back.chi2 == pytest.approx(baseline.chi2, abs=1.0)
    assert better_baseline(baseline, *asked) is None


def test_a_second_effect_that_only_led_the_first_back_is_dropped(investigated, monkeypatch):
    """A fit with the first effect in a local minimum, and a pair that is out of it."""
    best = investigated.trials[0]
    stuck = replace(best, delta_chi2=0.5 * best.delta_chi2)
    own = best.point.space.of("hardening")
    point = started_at(best.point, own, np.array([0.01]))
    pair = Trial(("turbulence", "hardening"), point, best.delta_chi2)
    monkeypatch.setattr(
        forward_selection,
        "_enlarged",
        lambda found, best, *_: [pair] if best is stuck else [],
    )
    found = further_effects.with_further_effects(
        replace(investigated, trials=[stuck]), 0, lambda text: None
    )
    assert found.joint is None
    assert found.trials[0].effects == best.effects
    assert found.trials[0].delta_chi2 == pytest.approx(best.delta_chi2, abs=1.0)


def test_an_effect_is_let_go_little_by_little(investigated, monkeypatch):
    """All else follows after each share, and what is left is the other effect alone."""
    best = investigated.trials[0]
    own = best.point.space.of("hardening")
    starts, fitted = [], multistart.fitted
    point = started_at(best.point, own, np.array([0.3]))
    monkeypatch.setattr(
        multistart, "fitted", lambda at, *how: starts.append(at) or fitted(at, *how)
    )
    alone = faded(point, "hardening")
    assert alone.chi2 == pytest.approx(best.point.chi2, abs=1.0)
    assert np.array_equal(alone.active, best.point.active)
    assert [at.x[own][0] / 0.3 for at in starts] == pytest.approx(SEARCH.fading_shares)
    monkeypatch.setattr(multistart.Linearisation, "moved", lambda *_: None)
    assert faded(point, "hardening") is None


def test_one_of_a_pair_is_fitted_alone_from_the_machine_as_given_too(investigated, monkeypatch):
    """Where letting the other go leads nowhere."""
    best = investigated.trials[0]
    own = best.point.space.of("hardening")
    point = started_at(best.point, own, np.array([0.3]))
    pair = Trial(("turbulence", "hardening"), point, 0.0)
    monkeypatch.setattr(effect_removal, "faded", lambda *_: None)
    alone = effect_removal.left_out(investigated, pair, "hardening", lambda text: None)
    assert alone.effects == ("turbulence",)
    assert alone.delta_chi2 == pytest.approx(best.delta_chi2, abs=1.0)
    assert np.array_equal(alone.point.active, best.point.active)


def test_the_machine_takes_over_what_an_effect_did_that_it_can_do_itself():
    """An effect that is one of the machine's parameters by another name leaves no trace."""
    entries = [e for e in recordings(1) if e.role != "show"]
    found = search_effects(Sled(), entries, [HARDENING, STIFFER], Settings(0.02, 0.005), 0)
    baseline, space = found.baseline, found.baseline.space
    place, own = (
        space.place("stiffer.size"),
        [d.name for d in space.parameters].index("spring.stiffness"),
    )
    x = baseline.x.copy()
    x[place], x[own] = 1.5 / space.parameters[place].scale, baseline.x[own] - 1.5 / 0.8
    absorbed = baseline.with_active(np.append(baseline.active, place)).moved(x, np.array([place]))
    assert absorbed.chi2 == pytest.approx(baseline.chi2, abs=5.0)
    rows = without(gauss_newton.relinearised(absorbed), ("stiffer",))
    as_it_is, half, whole = baseline.chi2_at(rows)
    assert np.all(rows[:, place] == 0.0)
    assert whole < half < as_it_is
    assert whole - baseline.chi2 < 0.01 * (as_it_is - baseline.chi2)


def test_what_is_left_is_the_best_refit_of_each_second_effect(investigated):
    point, nothing = investigated.baseline, np.zeros(0)
    best = Trial(("a",), point, 100.0)
    pairs = [Trial(("a", "b"), point, 109.0), Trial(("a", "b"), point, 102.0)]
    guesses = [Guess("b", 30.0, nothing, nothing, nothing)]
    assert _refuted(best, guesses, pairs, 1.0).delta_chi2 == pytest.approx(9.0)


def test_beside_a_better_base_every_effect_gains_less(investigated):
    better = replace(investigated.baseline, residual=0.999 * investigated.baseline.residual)
    rebased = _rebased(investigated, better)
    lost = (investigated.baseline.chi2 - better.chi2) / investigated.variance_factor
    below = [each for each in investigated.trials if each.point.chi2 < better.chi2]
    reductions = {each.effects: each.delta_chi2 - lost for each in below}
    assert {each.effects: each.delta_chi2 for each in rebased.trials} == pytest.approx(reductions)
    assert ("turbulence",) in reductions
    assert lost > 0.0 and rebased.baseline is better


def test_a_rival_that_went_astray_starts_from_the_machine_of_the_best(monkeypatch):
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    both = search_effects(Sled(), entries, [TURBULENCE, TWIN], Settings(0.02, 0.005), 0)
    baseline, space = both.baseline, both.baseline.space
    points = {each.effects[0]: each.point for each in both.trials}
    twin, first = points["twin"], points["turbulence"]
    moved = twin.x + 0.5 * np.isin(np.arange(twin.x.size), baseline.active)
    points["twin"] = twin.moved(moved, space.of("twin"))
    starts, settled = [], multistart.settled
    monkeypatch.setattr(
        multistart, "settled", lambda at, *how: starts.append(at) or settled(at, *how)
    )
    again = _crossed(points, baseline, SEARCH.name_limit, lambda text: None)
    assert again["twin"].chi2 == pytest.approx(twin.chi2, abs=0.5)
    assert again["turbulence"] is first
    own = baseline.active
    assert starts[0].x[own] == pytest.approx(first.x[own], abs=0.01)  # was 0.5 from there
    assert starts[0].x[space.of("twin")] == pytest.approx(twin.x[space.of("twin")], rel=1e-3)
    starts.clear()
    _crossed(points, baseline, 2.0 * baseline.chi2, lambda text: None)
    assert not starts  # none gains as much as that


def test_rounds_of_slopes_end_where_they_cannot_arrive(investigated, monkeypatch):
    rounds, relinearised = [], gauss_newton.relinearised
    monkeypatch.setattr(
        gauss_newton, "relinearised", lambda at: rounds.append(at) or relinearised(at)
    )
    baseline = investigated.baseline
    beside = baseline.moved(
        baseline.x + 3.0 * np.isin(np.arange(baseline.x.size), baseline.active), baseline.active
    )
    there = gauss_newton.settled(beside)
    assert len(rounds) > 1
    rounds.clear()
    assert gauss_newton.settled(there) is there and not rounds  # it has converged
    gauss_newton.settled(replace(there, last_reduction=np.inf))
    assert rounds
    rounds.clear()
    gauss_newton.settled(beside, below=baseline.chi2 - 2.0 * (beside.chi2 - baseline.chi2))
    assert len(rounds) == 1
