"""Several effects once more in the machine as given, where what is missing moves it no more."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from sled import WITH_GUST, three_found

from hannes.identification.diagnosis import effect_removal, further_effects
from hannes.identification.diagnosis.sets_as_given import (
    enlarged_as_given,
    restarted,
    surely_there,
)
from hannes.identification.diagnosis.trials import Joint, Trial, priced
from hannes.identification.diagnosis.tuning import SEARCH


@pytest.fixture(scope="module")
def three():
    """What a search finds of three hidden effects."""
    return three_found()


def silent(text):
    """Progress that nobody reads."""


def moved(point, by):
    """The point with its machine moved by standard deviations, and nothing refitted."""
    x = point.x.copy()
    x[point.space.uncertain] += by
    return point.moved(np.clip(x, point.space.low, point.space.high), np.zeros(0, int))


def test_effects_are_refitted_from_the_machine_as_given(three):
    """A machine that was moved far is no start of it: only their sizes are kept."""
    trial = three.joint.trial
    again = restarted(three, replace(trial, point=moved(trial.point, 2.0)), silent)
    assert again.effects == trial.effects
    assert again.point.chi2 == pytest.approx(trial.point.chi2, abs=2.0)


def test_others_that_are_missing_enter_beside_those_that_are_known(three):
    """In the machine that one effect leads to by itself, the others hardly show."""
    found = enlarged_as_given(three, ("hardening",), three.trials[0].point, silent)
    sets = {frozenset(each.effects): each.point.chi2 for each in found}
    assert sets[frozenset(WITH_GUST)] == pytest.approx(three.joint.trial.point.chi2, abs=2.0)


def test_a_search_that_ended_in_a_machine_that_is_improbable_goes_on_as_given(three, monkeypatch):
    """One effect with a machine that takes over the others' work, and no further one beside it."""
    monkeypatch.setattr(further_effects, "selected", lambda found, joint, *rest, **more: (
        replace(found, joint=joint if len(joint.trial.effects) > 1 else None,
                trials=[joint.trial, *found.trials[1:]])
    ))  # fmt: skip
    alone = [each for each in three.trials if each.effects == ("hardening",)]
    found = further_effects._from_as_given(replace(three, joint=None, trials=alone), silent)
    assert sorted(found.joint.trial.effects) == sorted(WITH_GUST)


def test_what_leaves_noise_in_a_probable_machine_is_not_tried_again(three, monkeypatch):
    monkeypatch.setattr(further_effects, "restarted", None)
    assert further_effects._from_as_given(three, silent) is three


def test_beside_as_many_as_are_named_together_no_other_is_asked(three):
    point = three.joint.trial.point
    assert list(enlarged_as_given(three, ("a", "b", "c", "d"), point, None)) == []


def test_a_selection_that_a_phase_broke_off_goes_on_where_noise_fails(three, monkeypatch):
    """Else what was not searched any more would look like nothing more there."""
    alone = replace(three, joint=None)
    monkeypatch.setattr(further_effects, "with_noise_at_best", lambda found, *rest: found)
    assert further_effects._in_their_noise(alone, 0, silent) is alone
    monkeypatch.setattr(further_effects, "has_phase", lambda trial: True)
    found = further_effects._in_their_noise(alone, 0, silent)
    assert sorted(found.joint.trial.effects) == sorted(WITH_GUST)


def test_effects_that_are_missed_by_little_may_stand_for_what_is_not_found_yet(three):
    losses = {"hardening": 1e4, "turbulence": 1e3, "gust": 0.5 * SEARCH.surely_missed}
    joint = Joint(three.joint.trial, losses=losses)
    assert sorted(surely_there(joint)) == ["hardening", "turbulence"]


def test_each_number_beyond_the_first_of_an_effect_is_paid_for(three):
    """Whatever values of the machine the recordings inform about."""
    trial = three.joint.trial
    fewer = trial.point.with_active(trial.point.active[1:])
    prices = [
        priced(three.baseline, Trial(trial.effects, each, 0.0), 1.0).delta_chi2
        for each in (trial.point, fewer)
    ]
    paid = SEARCH.simulated_price * three.baseline.noise.simulated_noise
    assert prices == pytest.approx([three.baseline.chi2 - trial.point.chi2 - paid] * 2)


@pytest.mark.parametrize(("stands", "kept"), [(True, {}), (False, {"gust": "any_torque"})])
def test_a_generic_disturbance_takes_a_name_where_it_does_as_much_once_refitted(
    three, monkeypatch, stands, kept
):
    """A linear prediction says no more than that it may: of large effects it is far off."""
    shape = SimpleNamespace(effect="any_torque", delta_chi2=1e9)
    monkeypatch.setattr(effect_removal, "screened", lambda point, names: [])
    linear = {"gust": {"any_torque": shape}}
    monkeypatch.setattr(
        effect_removal, "in_place_of", lambda point, name, guesses: linear.get(name, {})
    )
    instead = Trial(("any_torque",), three.joint.trial.point, 0.0)
    monkeypatch.setattr(effect_removal, "_instead", lambda *given: instead)
    monkeypatch.setattr(effect_removal, "stands_against", lambda *given: stands)
    joint = effect_removal._all_stand_ins(three, Joint(three.joint.trial), silent)
    assert joint.replaceable == kept


def test_where_the_search_was_ended_there_is_no_work_for_a_refit(three, monkeypatch):
    """The linear prediction decides, as a refit would end what could stand in for the others."""
    monkeypatch.setattr(effect_removal, "_instead", None)
    asked = three.joint.trial, "gust", SimpleNamespace(effect="any_torque"), silent
    assert not effect_removal._stands(replace(three, cut_short=True), *asked)
