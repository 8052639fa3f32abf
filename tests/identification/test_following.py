"""Slopes of plants whose runs can follow one another, and fits that go by them."""

from dataclasses import replace

import numpy as np
import pytest
from sled import KNOWN, TURBULENCE, Sled, recordings

from hannes.identification.diagnosis import decision as choices
from hannes.identification.diagnosis import gauss_newton
from hannes.identification.diagnosis.campaign_diagnosis import _masks
from hannes.identification.diagnosis.decision import GROWN_BESIDE, chosen
from hannes.identification.diagnosis.drift import Drift
from hannes.identification.diagnosis.effect_search import investigate
from hannes.identification.diagnosis.global_starts import SIZES, _sizes
from hannes.identification.diagnosis.linearisation import differenced
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model


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
        investigate(one, entries, list(KNOWN.values()), settings, 0) for one in (Follower(), Sled())
    ]


def test_by_runs_that_are_the_same_alone_all_is_the_same(both):
    followed, alone = both
    assert followed.trials[0].effects == alone.trials[0].effects
    assert followed.trials[0].gain == pytest.approx(alone.trials[0].gain, rel=1e-9)
    assert followed.base.x == pytest.approx(alone.base.x, abs=1e-9)


@pytest.mark.parametrize("lost", [(1,), (0, 1, 2, 3)], ids=["one", "the first, and so all"])
def test_what_cannot_follow_is_run_alone(both, monkeypatch, lost):
    base = both[0].base
    whole = differenced(base.ground.model, base.x, base.active, False)
    monkeypatch.setattr(Follower, "lost", lost)
    found = differenced(base.ground.model, base.x, base.active, False)
    for mine, theirs in zip([*found[0], *found[1]], [*whole[0], *whole[1]], strict=True):
        assert np.array_equal(mine, theirs)
    assert all(np.abs(slope).max(axis=1).all() for slope in found[1])


def test_a_machine_far_off_is_not_run_at_all(both, monkeypatch):
    base = both[1].base
    ran, vectors = [], Model.vectors
    monkeypatch.setattr(
        Model, "vectors", lambda *given: ran.append(len(given[2])) or vectors(*given)
    )
    away = base.x.copy()
    away[0] = 2.0 * np.sqrt(base.misfit)
    found = base.misfits(np.array([base.x, away]))
    assert found[0] == pytest.approx(base.misfit) and found[1] == np.inf
    assert ran == [1] * len(base.ground.model.groups)


def test_what_follows_a_place_is_told_by_slopes(both):
    """One value moved off: its own pull is enough to tell that it goes back."""
    base = both[1].base
    away = base.x + 0.5 * (np.arange(base.x.size) == 0)
    (alone,), (followed,) = (base.misfits(away[np.newaxis], each) for each in (False, True))
    assert alone > base.misfit + 0.1
    assert followed == pytest.approx(base.misfit, abs=0.1 * (alone - base.misfit) + 0.1)


def test_a_step_that_only_seemed_to_lead_down_is_not_taken(both, monkeypatch):
    base = both[1].base
    worse = base.moved(base.x + 3.0 * np.isin(np.arange(base.x.size), base.active), base.active)
    monkeypatch.setattr(gauss_newton, "_stepped", lambda point: worse)
    assert gauss_newton.fitted(base, 3) is base


def test_sizes_from_afar_are_inside_the_range_and_none_is_twice(both):
    given = both[1].given
    space, place = given.ground.model.space, int(given.ground.model.space.of("turbulence")[0])
    rows = _sizes(given, "turbulence")  # from 0 on
    assert rows[:, place].tolist() == list(SIZES)
    others = np.delete(rows - given.x, place, axis=1)
    assert not others.any() and rows.shape == (len(SIZES), space.size)


@pytest.mark.parametrize(
    ("gain", "of_name", "kind"),
    [
        (GROWN_BESIDE - 1.0, 60.0, "named"),
        (GROWN_BESIDE + 1.0, 60.0, "named_with_remainder"),
        (GROWN_BESIDE + 1.0, GROWN_BESIDE + 0.5, "unknown"),
        (1e9, 60.0, "unknown"),
    ],
)
def test_what_grows_beside_a_name_makes_it_less_clean(both, monkeypatch, gain, of_name, kind):
    """However little else speaks for the name: the rest of the misfit is not what grows."""
    trials = [replace(both[1].trials[0], gain=of_name)]
    found = replace(both[1], trials=trials)
    monkeypatch.setattr(choices, "held_out", lambda *_: 10.0)
    monkeypatch.setattr(choices, "_outdone", lambda *_: None)
    drift = Drift("turbulence", gain * found.unit)
    monkeypatch.setattr(choices, "drifts", lambda point, _: drift)
    masks = [_masks(found, role) for role in ("fit", "select")]
    choice = chosen(found, *masks)
    assert choice.kind == kind
