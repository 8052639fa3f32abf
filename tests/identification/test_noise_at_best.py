"""Noise estimated at the machine that the best effect leads to, and what one more effect needs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import HARDENING, KNOWN, TURBULENCE, Sled, recordings

from hannes.dynamics import stribeck, torque_ripple
from hannes.identification.diagnosis import effect_search, noise_at_best
from hannes.identification.diagnosis.baseline import FINE
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.noise_at_best import with_noise_at_best
from hannes.identification.diagnosis.noise_covariance import estimated_noise
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Joint, Trial, needed_beside
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded


@pytest.fixture(scope="module")
def one():
    """What a search finds of one hidden effect beside a small one, before further ones."""
    hidden = ((HARDENING, 900.0), (TURBULENCE, 0.5))
    entries = [e for e in recordings(3, hidden) if e.role != "show"]
    known = list(KNOWN.values())
    return replace(search_effects(Sled(), entries, known, Settings(0.02, 0.005), 0), joint=None)


def test_where_the_baseline_is_lost_noise_is_that_of_the_machine_found(one, monkeypatch):
    monkeypatch.setattr(noise_at_best, "_lost", lambda *given: True)
    said: list[str] = []
    again = with_noise_at_best(one, 0, said.append)
    best = one.trials[0].point
    expected = estimated_noise(best.model.as_machine(), best.x, FINE, 0)
    for point in (again.nominal, again.baseline, *(each.point for each in again.trials)):
        assert point.model is best.model
        for found, there in zip(point.noise.covariances, expected.covariances, strict=True):
            np.testing.assert_array_equal(found, there)
    assert said == ["noise, at the machine found"]
    assert again.trials[0].effects == one.trials[0].effects
    assert again.trials[0].point.chi2 < again.baseline.chi2


def test_noise_of_several_effects_is_that_of_the_machine_with_all_of_them(one, monkeypatch):
    monkeypatch.setattr(noise_at_best, "_lost", lambda *given: True)
    first = one.trials[0].point
    both = Trial(("hardening", "turbulence"), first.moved(0.9 * first.x, np.zeros(0, int)), 1e3)
    several = replace(one, joint=Joint(both, losses={"hardening": 1e3}))
    again = with_noise_at_best(several, 0, lambda text: None)
    expected = estimated_noise(first.model.as_machine(), both.point.x, FINE, 0)
    np.testing.assert_array_equal(
        again.joint.trial.point.noise.covariances[0], expected.covariances[0]
    )
    assert again.joint.trial.effects == both.effects and not again.joint.losses


def test_where_an_effect_has_a_phase_noise_is_estimated_once_more_where_that_came_to(
    one, monkeypatch
):
    """Its signature under a sampled controller changes with the phase, so no correction is made."""
    monkeypatch.setattr(noise_at_best, "_lost", lambda *given: False)
    monkeypatch.setattr(noise_at_best, "has_phase", lambda trial: True)
    said: list[str] = []
    again = with_noise_at_best(one, 0, said.append)
    assert said == ["noise, at the machine found"] * 2
    assert again.trials[0].effects == one.trials[0].effects
    assert torque_ripple.EFFECT.has_phase and not stribeck.EFFECT.has_phase


def test_where_the_bound_ends_the_second_noise_the_first_one_stands(one, monkeypatch):
    monkeypatch.setattr(noise_at_best, "has_phase", lambda trial: True)
    made, calls = noise_at_best._noise_at, []

    def ended_at_the_second(point, seed):
        calls.append(point)
        if len(calls) > 1:
            raise SearchEnded
        return made(point, seed)

    monkeypatch.setattr(noise_at_best, "_noise_at", ended_at_the_second)
    again = with_noise_at_best(one, 0, lambda text: None)
    assert again.cut_short and again.nominal.noise is not one.nominal.noise


@pytest.mark.parametrize(
    ("lost", "left", "waits"), [(True, 350.0, True), (True, 250.0, False), (False, 350.0, False)]
)
def test_beside_a_lost_baseline_noise_waits_for_further_effects(monkeypatch, lost, left, waits):
    monkeypatch.setattr(noise_at_best, "lost", lambda baseline: lost)
    best = SimpleNamespace(point=SimpleNamespace(chi2=left))
    assert noise_at_best.waits(SimpleNamespace(best=best, baseline=None, bins=100)) is waits


@pytest.mark.parametrize(
    ("baseline", "best", "lost"), [(400, 150, True), (250, 110, False), (400, 110, False),
                                   (400, 250, False)]
)  # fmt: skip
def test_a_baseline_is_lost_where_one_effect_explains_most_and_yet_something_is_left(
    baseline, best, lost
):
    found = SimpleNamespace(bins=100, baseline=SimpleNamespace(chi2=baseline))
    assert noise_at_best._lost(found, SimpleNamespace(chi2=best)) is lost


def test_an_ordinary_result_stays(one, monkeypatch):
    monkeypatch.setattr(noise_at_best, "_lost", lambda *given: False)
    assert with_noise_at_best(one, 0, print) is one


def test_single_effects_stand_where_the_bound_of_work_ends_it(one, monkeypatch):
    def ended(*given):
        raise SearchEnded

    monkeypatch.setattr(effect_search, "with_noise_at_best", ended)
    again = effect_search._with_further(one, 0, print)
    assert again.cut_short and again.trials == one.trials


@pytest.mark.parametrize(
    ("explained", "left", "needed"),
    [
        (1e3, 1000.0, SEARCH.name_limit),
        (1e6, 1000.0, SEARCH.sure_beside),  # it leaves what noise does: its law is right
        (1e6, 1600.0, SEARCH.share_of_rest * 600.0),
        (1e6, 5000.0, SEARCH.further_share * 1e6),
    ],
)
def test_what_effects_leave_bounds_by_how_much_their_laws_are_wrong(explained, left, needed):
    point = SimpleNamespace(chi2=left, residual=np.zeros(1000))
    assert needed_beside(Trial(("some",), point, explained), 1.0) == pytest.approx(needed)
    half = SimpleNamespace(chi2=2.0 * left, residual=np.zeros(1000))
    assert needed_beside(Trial(("some",), half, explained), 2.0) >= needed
