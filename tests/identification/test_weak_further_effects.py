"""A further effect that gains little must not raise the misfit of held-out recordings."""

from types import SimpleNamespace

import pytest

from hannes.identification.diagnosis import effect_removal
from hannes.identification.diagnosis.heldout import stands_on_heldout
from hannes.identification.diagnosis.tuning import SEARCH


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
