"""Noise estimated at the machine that the best effect leads to, and what one more effect needs."""

from types import SimpleNamespace

import numpy as np
import pytest
from sled import HARDENING, KNOWN, TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import effect_search, noise_at_best
from hannes.identification.diagnosis.baseline import FINE
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.noise_at_best import with_noise_at_best
from hannes.identification.diagnosis.noise_covariance import estimated_noise
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.trials import Trial, needed_beside
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.identification.diagnosis.work_bound import SearchEnded


@pytest.fixture(scope="module")
def one():
    """What a search finds of one hidden effect beside a small one."""
    hidden = ((HARDENING, 900.0), (TURBULENCE, 0.5))
    entries = [e for e in recordings(3, hidden) if e.role != "show"]
    return search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)


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
