"""What is compiled ahead is what is asked for later: else it only costs time."""

from types import SimpleNamespace

import pytest

from hannes import effects
from hannes.dataset.spec import load_spec
from hannes.identification.diagnosis.campaign_diagnosis import candidates
from hannes.identification.diagnosis.generic_disturbances import EFFECTS as GENERIC
from hannes.plants.hand.plant import HandPlant
from tools import compile_ahead
from tools.first_run import STEPS


def test_the_model_with_all_effects_is_that_of_a_diagnosis():
    plant = HandPlant()
    tried = candidates(SimpleNamespace(plant=plant, effects=effects()))
    usable = [each for each, why in tried.values() if not why]
    usable += [each for each in GENERIC if not plant.accepts(each)]
    assert compile_ahead.catalogue().effects == plant.with_effects(*usable).hand.effects


def test_a_name_is_run_by_what_it_stands_for(monkeypatch):
    ran = []
    monkeypatch.setattr(compile_ahead, "many", lambda hand: ran.append(hand.effects))
    monkeypatch.setattr(compile_ahead, "one", ran.append)
    compile_ahead.main(["hand", "floating", "large"])
    assert ran == [(), "floating-cylinder", load_spec("large").hand.effects]


@pytest.mark.parametrize("step", [each for each in STEPS if "compile_ahead" in each.command])
def test_steps_name_models_that_there_are(step):
    assert set(step.command.split()[1:]) <= set(compile_ahead.MODELS)
