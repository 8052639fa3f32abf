"""A baseline that goes far away and still leaves far too much, and what is not asked of it."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import (
    as_given,
    baseline,
    better_baseline,
    effect_search,
    gauss_newton,
    linearisation,
)
from hannes.identification.diagnosis.as_given import AsGiven
from hannes.identification.diagnosis.baseline import lost
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.global_starts import Promised
from hannes.identification.diagnosis.multistart import far_above, no_rival
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.tuning import FIT, SEARCH
from hannes.simulation.catalogue import effects

STATED = Settings(0.02, 0.005)
BINS = 100
COSTLY = replace(SEARCH, little_work=0.0)


@dataclass(frozen=True)
class Fit:
    """What `lost` and `settled` ask of a fit."""

    chi2: float
    residual: np.ndarray
    x: np.ndarray
    model: SimpleNamespace
    last_reduction: float = np.inf


def point(per_bin, farthest, work=SEARCH.little_work):
    """A baseline: what it leaves, where it is, what a round takes."""
    return Fit(
        chi2=per_bin * BINS,
        residual=np.zeros(BINS),
        x=np.array([0.3, -farthest]),
        model=SimpleNamespace(round_of_derivatives=lambda: work),
    )


def test_it_is_lost_where_it_leaves_much_and_is_far_away():
    assert lost(point(3.1, 10.1))
    assert not lost(point(2.9, 10.1))
    assert not lost(point(3.1, 9.9))
    assert not lost(point(3.1, 10.1, 0.9 * SEARCH.little_work))


@pytest.fixture
def searched(monkeypatch):
    """What was asked of repeats, and the search of a sled with turbulence, every round costly."""
    asked, judge = [], baseline.settings_from_repeats
    monkeypatch.setattr(baseline, "SEARCH", COSTLY)
    monkeypatch.setattr(
        baseline, "settings_from_repeats", lambda *some: asked.append(some) or judge(*some)
    )
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    return asked, search_effects(Sled(), entries, [TURBULENCE], STATED, 0)


def test_repeats_are_not_judged_by_its_noise_and_the_effect_is_found(searched):
    asked, found = searched
    assert lost_in(found.nominal, found.trials[0]) and not asked
    assert found.trials[0].effects == ("turbulence",)
    own = found.baseline.space.of("turbulence")
    value = found.baseline.space.parameters[own[0]].value(found.trials[0].point.x[own[0]])
    assert float(value) == pytest.approx(2.0, rel=0.05)


def lost_in(nominal, best):
    """Whether the machine as given, fitted without the effect, leaves far more than with it."""
    return baseline._begun(nominal).chi2 > 10.0 * best.point.chi2


def test_a_baseline_refitted_from_the_best_effect_is_not_taken_where_it_is_lost(
    searched, monkeypatch
):
    _, found = searched
    x = found.baseline.x + 5.0 * np.isin(np.arange(found.baseline.x.size), found.baseline.active)
    far = found.baseline.moved(x, found.baseline.active)  # a better one is near
    best = found.trials[0]
    asked = (far, best.point, best.effects, 1.0, lambda text: None)
    assert better_baseline.better_baseline(*asked) is None
    monkeypatch.setattr(better_baseline, "lost", lambda at: False)
    better = better_baseline.better_baseline(*asked)
    assert better is not None and better.chi2 < far.chi2


def test_far_above_is_ten_times_what_is_left_or_what_a_lost_baseline_leaves():
    assert far_above(point(50.0, 0.0), 1e4) == 1e5
    assert far_above(point(50.0, 0.0), 0.0) == 10.0 * 3.0 * BINS


def test_beside_a_fit_that_leaves_noise_a_rival_leaves_hardly_more():
    assert no_rival(point(50.0, 0.0), 0.9 * BINS) == 3.0 * BINS
    assert no_rival(point(50.0, 0.0), 1.1 * BINS) == far_above(point(50.0, 0.0), 1.1 * BINS)


def test_large_starts_in_the_machine_as_given_are_asked_for_once(searched):
    _, found = searched
    given = AsGiven(found.nominal, found.baseline, ["turbulence"])
    asked = given.promised
    starts = given.large(["turbulence"])
    assert [(at, guess.effect) for at, guess in starts] == [(found.nominal, "turbulence")]
    assert given.large(["turbulence"]) == []
    better = replace(asked, left={**asked.left, "another": 1e-9})
    little = asked.without - 0.1 * better.most
    better = replace(better, left={**better.left, "turbulence": little})
    assert given_as(found.nominal, better).large(["turbulence"]) == []


def given_as(nominal, promised):
    """The machine as given, its effects asked before."""
    given = AsGiven(nominal, None, [])
    given.promised = promised
    return given


def test_what_one_shape_promises_says_nothing_of_an_effect_with_others(monkeypatch):
    asked = []
    monkeypatch.setattr(as_given, "screened_widely", lambda at, names: asked.extend(names) or [])
    known = {name: effects()[name] for name in ("stribeck", "capstan", "gear_load")}
    nominal = SimpleNamespace(space=SimpleNamespace(effects=known))
    left = {"stribeck": 99.0, "capstan": 99.0, "gear_load": 0.0}
    given_as(nominal, Promised([*known], [], True, left, 100.0)).large([*known])
    assert asked == ["stribeck", "gear_load"]


def test_effects_are_looked_at_beside_the_best_machine_where_the_baseline_is_lost(
    searched, monkeypatch
):
    _, found = searched
    known = {"turbulence": found.trials[0].point}
    assert effect_search._beside_best(found.baseline, {}) is found.baseline
    beside = effect_search._beside_best(found.baseline, known)
    own = beside.space.of("turbulence")
    machine = np.setdiff1d(np.arange(beside.x.size), own)
    assert not beside.x[own].any()
    assert np.array_equal(beside.x[machine], found.trials[0].point.x[machine])
    monkeypatch.setattr(effect_search, "lost", lambda at: False)
    assert effect_search._beside_best(found.baseline, known) is found.baseline


@pytest.mark.parametrize(("falls", "rounds"), [(0.06, FIT.rounds), (0.04, 1)])
def test_far_above_noise_a_round_that_takes_little_of_what_is_left_is_the_last(
    monkeypatch, falls, rounds
):
    made = []
    monkeypatch.setattr(gauss_newton, "relinearised", lambda at: at)
    monkeypatch.setattr(
        gauss_newton,
        "_walked",
        lambda at, _: made.append(at) or point((1.0 - falls) * at.chi2 / BINS, 0.0),
    )
    gauss_newton.settled(point(1e6, 0.0))
    assert len(made) == rounds


def test_a_machine_far_from_its_prior_is_not_simulated_where_that_takes_much_work(
    searched, monkeypatch
):
    _, found = searched
    at = replace(found.nominal, residual=np.full(BINS, 1e4))  # which leaves more than any prior
    far = np.where(np.arange(at.x.size) == 0, 1.1 * FIT.farthest**0.5, 0.0)[np.newaxis]
    asked = []
    monkeypatch.setattr(
        type(at), "_vectors_at", lambda self, rows: asked.append(rows) or [np.full((1, 1), np.inf)]
    )
    monkeypatch.setattr(linearisation, "SEARCH", COSTLY)
    assert at.chi2_at(far) == np.inf and not asked
    monkeypatch.setattr(linearisation, "SEARCH", replace(SEARCH, little_work=np.inf))
    at.chi2_at(far)
    assert len(asked) == 1
