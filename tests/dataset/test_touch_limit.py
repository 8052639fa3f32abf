"""Commands that are limited from the touch on: the whole command before, a share of it after."""

import numpy as np
import pytest

from hannes import simulate
from hannes.bench.policy import GripMemory, GripSample, GripSettings, grip
from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table
from hannes.dataset.sampling import sample_grasp, sensed
from hannes.dataset.shard import grasps, recorded
from hannes.dataset.spec import read_spec
from hannes.dataset.touch_limit import (
    APPROACH,
    CREEP,
    FREE,
    NEAR,
    SETTLE,
    SPEED,
    TURN,
    _passing,
    approaching,
)
from hannes.dataset.touch_seen import seen_touch
from hannes.recognition.windowing import GrowingFeatures, Windowing
from hannes.simulation.experiment.reader import KEYS, read_experiment

SPEC = """
title = "pressed"
seed = 3
duration = "1.3 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.637 s", "9.84 rad"]]
[values]
"object.stiffness" = "3 kN/m"
"object.radius" = "25 mm"
[[grasps]]
name = "closed"
shape = "cylinder"
[[grasps]]
name = "pressed"
shape = "cylinder"
[grasps.values]
"command.touch_share" = "0.5"
"command.press_share" = "0.65"
"command.touch_delay" = "40 ms"
[[grasps]]
name = "pressed, as the sensors show the touch"
shape = "cylinder"
[grasps.values]
"command.touch_share" = "0.5"
"command.press_share" = "0.75"
"command.touch_seen" = "1"
"noise.current" = "10 mA"
"resolution.position" = "1.534 mrad"
"""


@pytest.fixture(scope="module")
def pair():
    """The same object closed on by the whole command, and by a limited one."""
    return simulated(0, 1)


def simulated(*numbers):
    spec = read_spec(SPEC)
    sampled = [sample_grasp(spec, number) for number in numbers]
    return grasps(spec, sampled, ("reference", "position", "current", "force"))


def test_the_command_passes_until_fingers_may_touch_and_then_slowly(pair):
    closed, pressed = pair
    near = int(np.argmax(closed["reference"] > NEAR))
    sent = np.arange(5, near - 5, 5)  # a set point every 5 ms, of what was wanted a tick before
    assert pressed["reference"][sent] == pytest.approx(closed["reference"][sent - 1], abs=1e-9)
    assert pressed["reference"][sent + 4] == pytest.approx(pressed["reference"][sent], abs=1e-9)
    before = slice(0, near - 8)  # on average, it comes 3 ms later
    late = pressed["position"][3 : near - 5] - closed["position"][before]
    assert np.abs(late).max() < 0.01
    seen = int(np.argmax(pressed["force"] > 1.0)) + 40
    sent = np.arange(5 * (near // 5) + 10, seen - 10, 5)
    assert np.diff(pressed["reference"][sent]) == pytest.approx(5e-3 * APPROACH)


def test_then_a_share_of_its_travel_counts_which_rises_slowly(pair):
    closed, pressed = pair
    first = int(np.argmax(pressed["force"] > 1.0))
    touch, seen = float(pressed["position"][first]), first + 40
    share = (pressed["reference"] - touch) / (9.84 - touch)
    assert share[max(seen + 140, 645)] == pytest.approx(0.5, abs=0.12)
    assert share[-1] == pytest.approx(0.65, abs=1e-3)
    assert np.diff(pressed["reference"]).max() <= 5.01 * 9.84 / 637
    assert 0.5 < pressed["force"][-1] / closed["force"][-1] < 0.75


def test_a_touch_that_the_sensors_show_limits_as_the_policy_does():
    (found,), sampled = simulated(2), sample_grasp(read_spec(SPEC), 2)
    free = simulate(sampled.hand, approaching(sampled).experiment).require()
    current, position = (sensed(sampled, free, name) for name in ("current", "position"))
    shown, touch = seen_touch(current, position, 1e-3)
    memory, points = GripMemory(), []
    for tick in range(shown + 450):
        wanted = float(np.interp(tick * 1e-3, [0.0, 0.637], [0.0, 9.84]))
        touched = tick + 1 >= 10 * np.ceil((shown + 1) / 10)  # once a window with it is over
        said = GripSample(1e-3, wanted, 0.0, touched, position[touch], 0.5, 0.0, 0.0, 0.0)
        memory, point = grip(GripSettings(), memory, said)
        points.append(point)
    sent = np.arange(5, len(points), 5)  # a set point every 5 ms, of the tick before
    assert found["reference"][sent] == pytest.approx(np.array(points)[sent - 1], abs=8e-3)
    assert found["reference"][sent + 4] == pytest.approx(found["reference"][sent], abs=1e-9)


def test_the_touch_is_the_one_that_recognition_counts_from(pair):
    current, position = pair[0]["current"], pair[0]["position"]
    growing = GrowingFeatures(Windowing())
    growing.take(list(np.stack([current, position, pair[0]["reference"]], axis=1)))
    shown, touch = seen_touch(current, position, 1e-3)
    assert touch == growing.touch
    assert seen_touch(current[:shown], position[:shown], 1e-3) is None


def test_what_is_never_touched_is_closed_on_slowly_at_the_end():
    times = np.arange(0.0, 1.3, 0.01)
    passing = _passing(times, np.minimum(15.4 * times, 9.84))
    near = NEAR / 15.4
    assert passing[30] == pytest.approx(4.62)
    assert passing[50] == pytest.approx(NEAR + APPROACH * (0.5 - near), abs=0.09)
    there = near + (FREE - NEAR) / APPROACH
    assert passing[-1] == pytest.approx(FREE + CREEP * (times[-1] - there), abs=0.005)


def test_the_policy_and_the_data_set_go_by_the_same_numbers():
    known = GripSettings()
    assert (NEAR, APPROACH) == (known.approach_from, known.approach_speed)
    assert (FREE, CREEP) == (known.free_to, known.free_speed)
    assert (SETTLE, SPEED, TURN) == (known.settle, known.probe_speed, known.speed)


def test_one_grasp_alone_is_that_of_the_data_set(pair):
    alone = recorded(read_spec(SPEC), 1)
    assert np.array_equal(alone["reference"], pair[1]["reference"])
    said = read_experiment(Table.parse(alone.experiment, "here", KEYS), None).reference
    assert np.interp(alone.time, *said.knots) == pytest.approx(alone["reference"], abs=1e-6)


@pytest.mark.parametrize(
    ("seen", "why"),
    [
        ('"0.5"', r"grasps\[2\]\.values .* is \"0\" or \"1\""),
        ('{ uniform = ["0", "1"] }', 'is "0" or "1"'),
        ('["0", "1"]', "leave one out"),
        ('"1"', "leave one out"),
    ],
)
def test_one_touch_is_meant(seen, why):
    text = SPEC.replace('"command.touch_seen" = "1"', f'"command.touch_seen" = {seen}')
    with pytest.raises(BadInput, match=why):
        read_spec(text + '"command.touch_delay" = "40 ms"\n')
    none = SPEC.replace('"command.touch_seen" = "1"', '"command.touch_seen" = "0"')
    assert read_spec(none + '"command.touch_delay" = "40 ms"\n').count == 3
