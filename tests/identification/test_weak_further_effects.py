"""A further effect that gains little must not raise the misfit of held-out recordings."""

from types import SimpleNamespace

import numpy as np
import pytest

from hannes.identification.diagnosis import effect_removal
from hannes.identification.diagnosis.heldout import stands_on_heldout
from hannes.identification.diagnosis.tuning import SEARCH
from hannes.plants.hand.plant import HandPlant


def test_a_law_that_is_there_lowers_what_was_held_out(investigated, monkeypatch):
    baseline, best = investigated.baseline, investigated.trials[0].point
    assert stands_on_heldout(baseline, best)
    assert not stands_on_heldout(best, baseline)
    assert stands_on_heldout(best, best)  # what held-out runs cannot show is not held against it
    monkeypatch.setattr("hannes.identification.diagnosis.heldout.runs_in_role", lambda *_: [0, 0])
    assert stands_on_heldout(best, baseline)  # none held out: it cannot be asked


@pytest.mark.parametrize(
    ("loss", "falls", "missed"),
    [
        (0.9 * SEARCH.name_limit, True, False),
        (1.1 * SEARCH.name_limit, True, True),
        (1.1 * SEARCH.name_limit, False, False),
        (1.1 * SEARCH.sure_beside, False, True),
    ],
)
def test_where_little_is_lost_without_an_effect_held_out_runs_decide(
    monkeypatch, loss, falls, missed
):
    monkeypatch.setattr(effect_removal, "needed_beside", lambda *_: SEARCH.name_limit)
    monkeypatch.setattr(effect_removal, "stands_on_heldout", lambda *_: falls)
    trial = SimpleNamespace(point=None)
    assert effect_removal._is_missed(trial, trial, loss, 1.0) is missed


@pytest.mark.parametrize(
    ("name", "loss", "per_bin", "faint"),
    [
        ("thumb_weak_spring", 30.0, 0.8, True),
        ("thumb_weak_spring", 50.0, 0.8, False),  # more than a share of the others
        ("thumb_weak_spring", 30.0, 1.1, False),  # without it more than noise is left
        ("mounting", 30.0, 0.8, False),  # no part has another like it
    ],
)
def test_a_fault_is_not_named_beside_a_law_that_explains_all(name, loss, per_bin, faint):
    space = SimpleNamespace(effects=HandPlant().catalogue)
    point = SimpleNamespace(space=space, chi2=per_bin * 100.0, residual=np.zeros(100))
    known = SimpleNamespace(point=point, delta_chi2=1000.0)
    assert effect_removal._is_faint_fault(known, name, loss) is faint


@pytest.mark.parametrize(
    ("effects", "missed", "sure"),
    [
        (("mounting", "falling_supply"), 2.0 * SEARCH.surely_missed, True),
        (("mounting", "falling_supply"), 0.5 * SEARCH.surely_missed, False),
        (("mounting", "falling_supply"), 1.1e4, False),  # more than both explain: nothing linear
        (("mounting", "thumb_weak_spring"), 2.0 * SEARCH.surely_missed, False),
    ],
)
def test_beside_a_fault_of_one_finger_no_effect_is_kept_by_a_linear_estimate(effects, missed, sure):
    point = SimpleNamespace(space=SimpleNamespace(effects=HandPlant().catalogue))
    best = SimpleNamespace(effects=effects, delta_chi2=1e4, point=point)
    assert effect_removal._surely_missed(best, missed, SEARCH.name_limit) is sure
