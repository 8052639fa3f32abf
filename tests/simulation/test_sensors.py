"""From a simulation to a recording: its channels, its seeded noise, the texts it carries."""

from dataclasses import replace

import numpy as np
import pytest
from runs import grasp

from hannes.core.errors import ComputationFailed
from hannes.simulation.experiment.experiment import Target
from hannes.simulation.experiment.load import read
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import load_hand
from hannes.simulation.hand.variables import OUTPUTS
from hannes.simulation.sensors import CHANNELS, observe
from hannes.simulation.simulate import simulate
from hannes.simulation.trajectory import Outcome

NOISE = {"current": 0.02, "position": 1e-3}


@pytest.fixture(scope="module")
def run():
    """A short grasp of an object that carries a sensor."""
    experiment = replace(grasp(duration=0.4), object=Target("cylinder", {}, sensor=True))
    return simulate(Hand(), experiment).require()


def noisy(run, seed=1, **noise):
    """The same run with sensor noise of this seed."""
    return replace(run, experiment=replace(run.experiment, noise=noise, seed=seed))


def test_channels_come_with_their_declared_units(run):
    recording = observe(Hand(), run)
    assert recording.names == CHANNELS and (recording.plant, recording.source) == (
        "hand",
        "simulated",
    )
    declared = {slot.name: slot.unit for slot in OUTPUTS}
    assert all(recording.units[name] == declared[name] for name in CHANNELS)
    for name in CHANNELS:
        assert np.array_equal(recording[name], run[name])


def test_the_sensor_is_recorded_where_the_object_carries_one(run):
    bare = replace(run, experiment=replace(run.experiment, object=Target("cylinder")))
    assert "sensor" in observe(Hand(), run) and "sensor" not in observe(Hand(), bare)
    without = replace(run, experiment=replace(run.experiment, object=None))
    assert "sensor" not in observe(Hand(), without)


def test_noise_is_white_and_of_the_given_size(run):
    recording = observe(Hand(), noisy(run, **NOISE))
    for name, spread in NOISE.items():
        noise = recording[name] - run[name]
        assert noise.std() == pytest.approx(spread, rel=0.15)  # some 400 samples
        assert abs(noise.mean()) < 0.2 * spread
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.2
    assert np.array_equal(recording["duty"], run["duty"])


def test_noise_depends_on_seed_and_channel_alone(run):
    one, again, other = (observe(Hand(), noisy(run, s, **NOISE)) for s in (7, 7, 8))
    assert one == again
    assert not np.array_equal(one["current"], other["current"])
    alone = observe(Hand(), noisy(run, 7, current=NOISE["current"]))
    assert np.array_equal(alone["current"], one["current"])
    apart = [(one[name] - run[name]) / spread for name, spread in NOISE.items()]
    assert abs(np.corrcoef(*apart)[0, 1]) < 0.2


def test_a_seed_is_kept_only_where_something_was_drawn(run):
    assert observe(Hand(), run).seed is None
    assert observe(Hand(), noisy(run, 7, **NOISE)).seed == 7


def test_the_texts_of_a_recording_give_the_same_run_again(run, tmp_path):
    hand = Hand().with_effects("gear_load").with_values({"motor.resistance": 3.3})
    recording = observe(hand, noisy(run, **NOISE))
    (variant,) = read(recording.experiment, "its experiment")
    assert dict(variant.hand.parameters) == dict(hand.parameters)
    assert variant.hand.effects == hand.effects
    assert dict(variant.experiment.noise) == NOISE and variant.experiment.seed == 1
    assert np.array_equal(variant.experiment.times, run.time)
    assert variant.experiment.object == run.experiment.object
    assert np.array_equal(variant.experiment.reference.knots, run.experiment.reference.knots)
    (tmp_path / "hand.toml").write_text(recording.hand, encoding="utf-8")
    assert dict(load_hand(tmp_path / "hand.toml").parameters) == dict(hand.parameters)


def test_a_run_that_broke_is_not_a_recording(run):
    broken = replace(run, outcome=Outcome.SOLVER_GAVE_UP, message="step size")
    with pytest.raises(ComputationFailed, match=r"gave up.*step size"):
        observe(Hand(), broken)
