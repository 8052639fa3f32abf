"""The hand as a plant: a recording's own experiment decides what is simulated for it."""

from dataclasses import replace

import numpy as np
import pytest
from runs import grasp

from hannes.errors import BadInput
from hannes.hand import Hand
from hannes.hand_plant import HandPlant, posed
from hannes.observe import observe
from hannes.simulate import simulate
from hannes.spec import load_experiment

DURATION = 0.12  # s, until the reference has wound the wire


def recorded(controller):
    """A free closure as the bench would have logged it under this controller."""
    run = simulate(Hand(), grasp(None, DURATION, controller=controller), rtol=1e-5)
    return observe(Hand(), run), run


@pytest.mark.parametrize("controller", ["continuous", "sampled"])
def test_a_recording_is_simulated_under_its_own_controller(controller):
    recording, run = recorded(controller)
    assert posed(recording).controller == controller
    again = HandPlant().simulate({}, recording)
    apart = {name: np.abs(again[name] - run[name]).max() for name in ("current", "position")}
    assert apart["current"] < 1e-3 and apart["position"] < 1e-4


def test_the_two_controllers_differ_by_more_than_that():
    """Else the test above would pass whichever controller ran."""
    (_, one), (_, other) = recorded("continuous"), recorded("sampled")
    assert np.abs(one["current"] - other["current"]).max() > 1e-2


def test_a_recording_without_experiment_is_simulated_under_the_continuous_controller():
    recording = replace(recorded("sampled")[0], experiment="")
    assert posed(recording).controller == "continuous"


def test_a_recording_without_reference_and_experiment_is_refused():
    recording = recorded("continuous")[0]
    channels = {name: recording.channels[name] for name in ("time", "current")}
    bare = replace(recording, channels=channels, units={"time": "s", "current": "A"}, experiment="")
    with pytest.raises(BadInput, match="neither a channel reference_rad nor an experiment"):
        posed(bare)


def test_what_puts_the_object_elsewhere_puts_that_of_an_experiment_elsewhere_too():
    """Else a campaign's scatter of places would not reach an object that has a place of its own."""
    plant, moved = HandPlant(), {"object.x": HandPlant().parameters["object.x"] + 1e-3}
    (ball,) = load_experiment("soft-ball")
    run = observe(Hand(), simulate(Hand(), ball.experiment))
    assert "object.x" in ball.experiment.object.values
    values = dict(ball.experiment.object.values)
    values["object.x"] += 1e-3
    there = replace(ball.experiment, object=replace(ball.experiment.object, values=values))
    seen, before = plant.simulate(moved, run), plant.simulate({}, run)
    wanted = observe(Hand(), simulate(Hand(), there, rtol=1e-5))
    assert np.abs(seen["current"] - wanted["current"]).max() < 1e-2
    assert np.abs(seen["current"] - before["current"]).max() > 3e-2
