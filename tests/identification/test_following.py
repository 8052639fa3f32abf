"""Slopes of plants whose runs can follow one another, and fits that go by them."""

from dataclasses import replace

import numpy as np
import pytest
from sled import KNOWN, TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import decision as choices
from hannes.identification.diagnosis import gauss_newton, reservations
from hannes.identification.diagnosis.decision import decide
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.heldout import runs_in_role
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.identification.diagnosis.sizes_looked_at import _sizes
from hannes.identification.diagnosis.trend import Trend
from hannes.identification.diagnosis.tuning import SEARCH, VERDICT


class Follower(Sled):
    """A sled whose runs follow the first one: here they are as they are alone."""

    lost: tuple[int, ...] = ()  # rows that cannot

    def alike(self, columns, recording, channels):
        rows = len(next(iter(columns.values())))
        runs = [
            self.simulate({name: float(c[k]) for name, c in columns.items()}, recording)
            for k in range(rows)
        ]
        return [None if k in Follower.lost else run for k, run in enumerate(runs)]


@pytest.fixture(scope="module")
def both():
    """What is found by sleds whose runs follow the first one, and by those whose do not."""
    entries = [each for each in recordings(1, ((TURBULENCE, 2.0),)) if each.role != "show"]
    settings = Settings(0.02, 0.005)
    return [
        search_effects(one, entries, list(KNOWN.values()), settings, 0)
        for one in (Follower(), Sled())
    ]


def test_by_runs_that_are_the_same_alone_all_is_the_same(both):
    followed, alone = both
    assert followed.trials[0].effects == alone.trials[0].effects
    assert followed.trials[0].delta_chi2 == pytest.approx(alone.trials[0].delta_chi2, rel=1e-9)
    assert followed.baseline.x == pytest.approx(alone.baseline.x, abs=1e-9)


@pytest.mark.parametrize("lost", [(1,), (0, 1, 2, 3)], ids=["one", "the first, and so all"])
def test_what_cannot_follow_is_run_alone(both, monkeypatch, lost):
    baseline = both[0].baseline
    whole = differenced(baseline.model, baseline.x, baseline.active, False)
    monkeypatch.setattr(Follower, "lost", lost)
    found = differenced(baseline.model, baseline.x, baseline.active, False)
    for mine, theirs in zip([*found[0], *found[1]], [*whole[0], *whole[1]], strict=True):
        assert np.array_equal(mine, theirs)
    assert all(np.abs(slope).max(axis=1).all() for slope in found[1])


def test_a_machine_far_off_is_not_run_at_all(both, monkeypatch):
    baseline = both[1].baseline
    ran, vectors = [], Model.vectors
    monkeypatch.setattr(
        Model, "vectors", lambda *nominal: ran.append(len(nominal[2])) or vectors(*nominal)
    )
    away = baseline.x.copy()
    away[0] = 2.0 * np.sqrt(baseline.chi2)
    found = baseline.chi2_at(np.array([baseline.x, away]))
    assert found[0] == pytest.approx(baseline.chi2) and found[1] == np.inf
    assert ran == [1] * len(baseline.model.groups)


def test_what_follows_a_point_is_predicted_linearly(both):
    """One parameter moved off: the gradient alone leads it back."""
    baseline = both[1].baseline
    away = baseline.x + 0.5 * (np.arange(baseline.x.size) == 0)
    (alone,), (followed,) = (baseline.chi2_at(away[np.newaxis], each) for each in (False, True))
    assert alone > baseline.chi2 + 0.1
    assert followed == pytest.approx(baseline.chi2, abs=0.1 * (alone - baseline.chi2) + 0.1)


def test_a_step_that_only_seemed_to_lead_down_is_not_taken(both, monkeypatch):
    baseline = both[1].baseline
    worse = baseline.moved(
        baseline.x + 3.0 * np.isin(np.arange(baseline.x.size), baseline.active), baseline.active
    )
    monkeypatch.setattr(gauss_newton, "_stepped", lambda point: worse)
    assert gauss_newton.fitted(baseline, 3) is baseline


def test_global_sizes_are_inside_the_range_and_none_is_twice(both):
    nominal = both[1].nominal
    space, place = nominal.space, int(nominal.space.of("turbulence")[0])
    rows = _sizes(nominal, "turbulence", SEARCH.global_sizes)  # from 0 on
    assert rows[:, place].tolist() == list(SEARCH.global_sizes)
    others = np.delete(rows - nominal.x, place, axis=1)
    assert not others.any() and rows.shape == (len(SEARCH.global_sizes), space.size)


@pytest.mark.parametrize(
    ("delta_chi2", "of_name", "kind"),
    [
        (VERDICT.trend_beside_name - 1.0, 60.0, "named"),
        (VERDICT.trend_beside_name + 1.0, 60.0, "named_with_remainder"),
        (VERDICT.trend_beside_name + 1.0, VERDICT.trend_beside_name + 0.5, "unknown"),
        (1e9, 60.0, "unknown"),
    ],
)
def test_what_grows_beside_a_name_makes_it_less_clean(both, monkeypatch, delta_chi2, of_name, kind):
    """However little else speaks for the name: the rest of the misfit is not what grows."""
    trials = [replace(both[1].trials[0], delta_chi2=of_name)]
    found = replace(both[1], trials=trials)
    monkeypatch.setattr(choices, "heldout_reduction", lambda *_: 10.0)
    monkeypatch.setattr(reservations, "_underexplained", lambda *_: None)
    trend = Trend("turbulence", delta_chi2 * found.variance_factor)
    monkeypatch.setattr(reservations, "strongest_trend", lambda point, _: trend)
    masks = [runs_in_role(found.baseline.model.groups, role) for role in ("fit", "select")]
    decision = decide(found, *masks)
    assert decision.kind == kind
