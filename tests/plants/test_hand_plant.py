"""The hand as a plant: a recording's own experiment decides what is simulated for it."""

from dataclasses import replace

import numpy as np
import pytest
from runs import grasp

from benchmarks.truth.bench import CURRENT
from benchmarks.truth.campaign import make
from benchmarks.truth.protocol import closures
from hannes.campaigns.campaign import Entry
from hannes.control.sensor_noise import gaussian
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.core.recording.white_noise import roughness
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.settings import Settings
from hannes.identification.diagnosis.simulator import Model
from hannes.plants.hand.batch_runs import own
from hannes.plants.hand.candidate_runs import proposals
from hannes.plants.hand.plant import HandPlant
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.simulation.catalogue import effects
from hannes.simulation.experiment.experiment import Target
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.hand.hand import Hand
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate

DURATION = 0.12  # s, until the reference has wound the wire


def recorded(controller):
    """A free closure as the bench would have logged it under this controller."""
    run = simulate(Hand(), grasp(None, DURATION, controller=controller), rtol=1e-5)
    return observe(Hand(), run), run


@pytest.mark.parametrize("controller", ["continuous", "sampled"])
def test_a_recording_is_simulated_under_its_own_controller(controller):
    recording, run = recorded(controller)
    assert experiment_of(recording).controller == controller
    again = HandPlant().simulate({}, recording)
    apart = {name: np.abs(again[name] - run[name]).max() for name in ("current", "position")}
    assert apart["current"] < 1e-3 and apart["position"] < 1e-4


def test_the_two_controllers_differ_by_more_than_that():
    """Else the test above would pass whichever controller ran."""
    (_, one), (_, other) = recorded("continuous"), recorded("sampled")
    assert np.abs(one["current"] - other["current"]).max() > 1e-2


def test_a_recording_without_experiment_is_simulated_under_the_continuous_controller():
    recording = replace(recorded("sampled")[0], experiment="")
    assert experiment_of(recording).controller == "continuous"


def test_objects_that_are_given_otherwise_are_not_one_object():
    """Else the values of the last would be taken for all."""
    soft, stiff = (
        grasp(Target("cylinder", {"object.stiffness": k}), DURATION) for k in (300.0, 40e3)
    )
    assert own(soft) == own(replace(soft, duration=1.0)) != own(stiff)
    bare = grasp(Target("cylinder"), DURATION)
    assert own(bare) != own(replace(bare, values={"object.radius": 0.03}))


def test_phases_follow_the_experiment_where_no_motion_was_recorded():
    recording, _ = recorded("continuous")
    kept = {name: recording[name] for name in ("time", "current")}
    blind = replace(recording, channels=kept, units={"time": "s", "current": "A"})
    blind_phases, seen = (HandPlant().phases(each) for each in (blind, recording))
    assert all(np.array_equal(blind_phases[name], seen[name]) for name in seen)


def test_proposals_keep_objects_apart_whose_conditions_begin_alike():
    recording, _ = recorded("continuous")
    runs = {"grasp, rigid": recording, "grasp, soft": recording, "void, slow": recording}
    found = proposals(runs, {"grasp, rigid": "a", "grasp, soft": "b", "void, slow": "c"})
    for name in ("grasp, rigid, half speed", "grasp, soft, half speed", "void, half speed"):
        assert name in found


def test_a_recording_without_reference_and_experiment_is_refused():
    recording = recorded("continuous")[0]
    channels = {name: recording.channels[name] for name in ("time", "current")}
    bare = replace(recording, channels=channels, units={"time": "s", "current": "A"}, experiment="")
    with pytest.raises(BadInput, match="neither a channel reference_rad nor an experiment"):
        experiment_of(bare)


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


def test_noise_of_a_sensor_is_white_and_the_same_again():
    drawn = np.array([[gaussian(seed, tick) for tick in range(3000)] for seed in range(4)])
    assert np.abs(drawn.mean(axis=1)).max() < 4.0 / np.sqrt(3000)
    assert drawn.std(axis=1) == pytest.approx(np.ones(4), abs=0.05)
    assert np.mean(drawn**4) == pytest.approx(3.0, abs=0.2)
    power = np.abs(np.fft.rfft(drawn)[:, 1:-1]) ** 2 / 3000
    assert power.max() < np.log(4 * 1500) + 5.0  # the largest of exponential numbers
    assert np.abs(np.corrcoef(drawn) - np.eye(4)).max() < 0.08
    assert gaussian(3, 141) == gaussian(3, 141)


def test_noisy_firmware_reads_noise_and_moves_the_hand():
    recording, _ = recorded("sampled")
    plant = HandPlant()
    drawn = {
        "controller.current_noise": np.array([10e-3]),
        "controller.noise_seed": np.array([7.0]),
    }
    (run,) = plant.many(drawn, recording, ("current",), exact=True)
    measured = replace(recording, channels={**recording.channels, "current": run["current"]})
    columns = plant.noisy(measured, 30)
    assert columns["controller.current_noise"] == pytest.approx(np.full(30, 10e-3), rel=0.15)
    runs = plant.many(columns, measured, ("current", "position"), exact=True)
    current, position = (np.array([each[n] for each in runs]) for n in ("current", "position"))
    assert current.std(axis=0)[20:].mean() == pytest.approx(10e-3, rel=0.5)
    assert 0.0 < position.std(axis=0)[-1] < 5e-3
    again = plant.many(columns, measured, ("position",), exact=True)
    assert all((a["position"] == b).all() for a, b in zip(again, position, strict=True))
    quiet = plant.many(columns, measured, ("position",), exact=False)
    assert np.ptp([each["position"][-1] for each in quiet]) == 0.0


def test_what_the_loop_makes_of_noise_is_no_noise():
    made = make(closures(1), 11)
    (recording,) = made.recordings.values()
    assert roughness(recording["current"]) > 1.15 * CURRENT
    columns = HandPlant().noisy(recording, 3)
    assert columns["controller.current_noise"] == pytest.approx(np.full(3, CURRENT), rel=0.1)


def test_runs_near_each_other_are_as_right_as_one_by_one():
    """At a wide tolerance firmware's ticks add up: what they add is taken away again."""
    plant, recording = HandPlant(), recorded("sampled")[0]
    one = {name: each[:1] for name, each in plant.unrounded(1).items()}
    (fine,) = plant.many(one, recording, ("position", "current"), exact=True)
    still = {"controller.current_noise": np.zeros(1), **one}
    (near,) = plant.many(still, recording, ("position", "current"), exact=True)
    for name, each in fine.items():
        assert near[name] == pytest.approx(each, abs=1e-12 * np.ptp(each))


@pytest.mark.parametrize(("digits", "counted"), [(9, True), (7, True), (6, True), (5, False)])
def test_counts_are_recognised_as_far_as_a_file_has_digits(digits, counted):
    """A full closure ends at 20 rad: seven digits round it by three thousandths of a count."""
    time, step = np.linspace(0.0, 1.0, 801), 2.0 * np.pi / 2.0**12
    angle = np.array([float(f"{step * round(each):.{digits}g}") for each in 13_000.0 * time])
    channels = {"time": time, "position": angle}
    made = Recording(channels, {"time": "s", "position": "rad"})
    assert HandPlant().counted(made) is counted
    smooth = Recording({**channels, "position": 20.0 * time}, {"time": "s", "position": "rad"})
    assert not HandPlant().counted(smooth)


def test_noisy_positions_are_counted_where_recorded_ones_are():
    plant, step = HandPlant(), 2.0 * np.pi / 2.0**12
    (counted,) = make(closures(1), 11).recordings.values()
    smooth = recorded("sampled")[0]
    for recording, is_counted in ((counted, True), (smooth, False)):
        (run,) = plant.many(plant.noisy(recording, 1), recording, ("position",), exact=True)
        counts = run["position"] / step
        assert np.allclose(counts, np.round(counts), atol=1e-6) == is_counted


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "steps"),
    [
        ("current_lag", 0.7),
        ("current_lag", 3.0),
        ("current_lag", 14.0),
        ("measurement_delay", 0.7),
        ("measurement_delay", 3.0),
    ],
)
def test_effects_on_what_firmware_reads_are_mended_for_its_ticks(name, steps):
    """A continuous controller makes another mark of them, or none that is like it."""
    both = [effects()["current_lag"], effects()["measurement_delay"]]  # one compilation
    groups = grouped(HandPlant(), [Entry("closure", recorded("sampled")[0], "void", "fit")])
    space = ParameterSpace(HandPlant(), groups, Settings(), both)
    model, x = Model(HandPlant(), groups, space, both), np.zeros(space.size)
    rows = np.array([x, x])
    rows[1, space.of(name)] = steps
    plain, with_effect = (
        groups[0].vector(each)
        for each in model.simulated(groups[0], rows, True, True, HandPlant().unrounded(2))
    )
    by_ticks = with_effect - plain
    smooth, mended = (
        np.diff(each.vectors(groups[0], rows, True), axis=0)[0]
        for each in (model, model.with_sampling_correction(x + 0.8 * (rows[1] - x), [name]))
    )
    size = np.linalg.norm(by_ticks)
    assert np.linalg.norm(smooth - by_ticks) > 0.4 * size
    assert np.linalg.norm(mended - by_ticks) < 0.1 * size


def test_a_noisy_force_sensor_alone_is_no_contact():
    time, rng = np.arange(500) * 1e-3, np.random.default_rng(0)
    force = 0.05 * rng.standard_normal((2, time.size)) + [[0.0], [20.0]] * (time > 0.25)
    units = {"time": "s", "position": "rad", "force": "N"}
    for values, touched in zip(force, (0.0, 1.0), strict=True):
        channels = {"time": time, "position": time, "force": values}
        contact = HandPlant().quantities(Recording(channels, units))["contact"]
        assert (contact[time > 0.25] == touched).all() and not contact[time <= 0.25].any()


def test_runs_say_their_work_as_seconds_of_ordinary_grasps():
    resistance = Hand().parameters["motor.resistance"]
    asked = {"motor.resistance": np.array([resistance])}, ("current",)
    work = {}
    for controller in ("continuous", "sampled"):
        recording = recorded(controller)[0]
        made = HandPlant().many(asked[0], recording, asked[1], exact=True)
        work[controller] = made.work / np.ptp(recording.time)
    assert 0.2 < work["continuous"] < 3.0 and work["sampled"] > 2.0 * work["continuous"]
