"""Gross mistakes of a lab: each is one fault of the right kind; the sound recording has none."""

from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns.check import check
from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import Axis
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.experiment.load import load_experiment
from hannes.simulation.experiment.shipped import folder
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate

CLOSE_AND_OPEN = """
title = "Close and open"
duration = "1.8 s"
[reference]
kind = "ramp"
points = [["0 s", "0 rad"], ["0.7 s", "8 rad"], ["0.9 s", "8 rad"], ["1.6 s", "0 rad"]]
"""
ALL = ("reference", "position", "current", "duty")


@pytest.fixture(scope="module")
def closed(tmp_path_factory):
    """A sound recording of a hand that closes, waits and opens."""
    file = tmp_path_factory.mktemp("experiment") / "close.toml"
    file.write_text(CLOSE_AND_OPEN)
    (each,) = load_experiment(file)
    experiment = replace(each.experiment, noise={"current": 10e-3}, seed=3)
    run = observe(each.hand, simulate(each.hand, experiment).require())
    return replace(run, experiment=CLOSE_AND_OPEN)


def kept(recording, names, **changed):
    channels = {name: recording[name] for name in ("time", *names)} | changed
    return replace(
        recording, channels=channels, units={name: recording.units[name] for name in channels}
    )


def serious(recording):
    return [each for each in check(recording, HandPlant()) if each.level != "note"]


def only(recording, kind, channel, level="fault"):
    (found,) = serious(recording)
    assert (found.level, found.kind, found.channel) == (level, kind, channel), found
    return found


@pytest.mark.parametrize("names", [ALL, ALL[:3], ALL[1:], ALL[1:3], (*ALL, "supply")])
def test_a_sound_recording_has_none(closed, names):
    assert serious(kept(closed, names)) == []


@pytest.mark.parametrize("names", [ALL, ALL[1:], (*ALL, "supply")])
@pytest.mark.parametrize("factor", [10.0, 0.1, 4.0])
def test_a_current_of_another_unit_by_the_law_of_the_winding(closed, names, factor):
    found = only(kept(closed, names, current=factor * closed["current"]), "unit", "current")
    assert found.size == pytest.approx(factor, rel=0.1) and "ohm" in found.text
    scale = float(found.mend[0].removeprefix("channels.current.scale = "))
    assert scale == pytest.approx(1.0 / factor, rel=0.1)


def test_a_gain_that_machines_have_is_no_fault(closed):
    assert serious(kept(closed, ALL, current=1.3 * closed["current"])) == []


def test_a_current_beyond_what_the_supply_can_drive(closed):
    found = only(kept(closed, ALL[:3], current=15.0 * closed["current"]), "unit", "current")
    assert "the supply drives" in found.text and found.mend == ("leave out channels.current",)
    assert 1.0 < found.size < 3.0  # a bound alone: how much too large is not known
    found = only(kept(closed, ALL[:3], current=1000.0 * closed["current"]), "unit", "current")
    assert found.mend == ('channels.current.unit = "mA"',)


def test_the_command_of_another_experiment(closed):
    wrong = replace(closed, experiment=(folder() / "dynamometer.toml").read_text())
    found = only(wrong, "command", "reference")
    assert "1.6 s" in found.text and "wrong experiment" in found.text
    free = replace(closed, experiment=(folder() / "void-closure.toml").read_text())
    assert "leave experiment out" in only(free, "command", "reference", "warning").text


@pytest.mark.parametrize("name", ["dynamometer", "void-closure", "soft-ball"])
def test_a_motion_of_another_experiment(closed, name):
    wrong = replace(kept(closed, ALL[1:3]), experiment=(folder() / f"{name}.toml").read_text())
    found = only(wrong, "unlike", "position")
    assert "times as long as the experiment's command" in found.text


@pytest.mark.parametrize("names", [ALL, ALL[:3], ALL[1:]])
@pytest.mark.parametrize("noisy", [False, True])
@pytest.mark.parametrize(
    ("first", "last", "rest"),
    [(900, 1801, 1.0), (900, 1801, 0.5), (500, 1801, 0.3), (700, 880, 0.5)],
)
def test_a_drive_that_is_switched_off(closed, names, noisy, first, last, rest):
    position, current = closed["position"].copy(), closed["current"].copy()
    duty, since = closed["duty"].copy(), np.arange(last - first) / 1000.0
    position[first:last] = position[first] * (rest + (1.0 - rest) * np.exp(-since / 0.1))
    for k in range(last, position.size):  # it catches up
        position[k] = position[k - 1] + np.clip(
            closed["position"][k] - position[k - 1], -0.03, 0.03
        )
    noise = np.random.default_rng(0).standard_normal(last - first)
    current[first:last], duty[first:last] = 0.01 * noise * noisy, 0.0
    changed = {"position": position, "current": current, "duty": duty}
    changed = {name: each for name, each in changed.items() if name in names}
    found = only(kept(closed, names, **changed), "disabled", "current")
    assert found.time == pytest.approx(closed.time[first], abs=0.02)


def test_a_position_that_stands_for_long_is_one_fault(closed):
    position = closed["position"].copy()
    position[600:1000] = position[600]
    found = only(kept(closed, ALL, position=position), "frozen", "position")
    assert found.time == pytest.approx(0.6, abs=2e-3) and found.mend[0].startswith("time.cut")


@pytest.mark.parametrize("zero", [0.3, -0.5])
def test_a_zero_is_as_large_as_it_is(closed, zero):
    found = only(kept(closed, ALL, position=closed["position"] + zero), "zero", "position")
    assert found.size == pytest.approx(zero, abs=0.005)


def test_a_current_that_is_cut_off_for_long(closed):
    top = 0.6 * float(closed["current"].max())
    found = only(
        kept(closed, ALL, current=np.minimum(closed["current"], top)), "saturated", "current"
    )
    assert found.size > 0.2


def test_a_command_that_is_the_motion_once_more(closed):
    found = only(kept(closed, ALL, reference=closed["position"]), "swapped", "position")
    assert "equals reference in every sample" in found.text and found.mend


def test_a_current_of_which_little_is_within_the_range(closed):
    """Coarse and slow: its tops are long and not abrupt, and as far both ways."""
    coarse = 5e-3 * np.round(closed["current"] / 5e-3)
    found = serious(kept(closed, ALL, current=np.clip(coarse, -0.15, 0.15)))
    assert {(each.kind, each.channel) for each in found if each.level == "fault"} == {
        ("saturated", "current")
    }
    assert serious(kept(closed, ALL, current=coarse)) == []


@pytest.mark.parametrize("share", [0.28, 0.35])
def test_a_log_that_ends_on_its_way_has_no_other_pace(closed, share):
    """Of a ramp alone a late start is as a pace."""
    count = round(share * len(closed))
    cut = {name: closed[name][:count] for name in ("time", *ALL)}
    assert serious(kept(closed, ALL, **cut)) == []


@pytest.fixture(scope="module")
def shivering():
    """A sound axis whose controller answers to its encoder's noise, volts in a drive of four."""
    rng, dt, count = np.random.default_rng(1), 1e-3, 4000
    time = dt * np.arange(count)
    reference = 0.03 * (1.0 - np.cos(2.0 * np.pi * time / 2.0))
    place = speed = error = 0.0
    position, drive = np.empty(count), np.empty(count)
    for k in range(count):
        position[k] = 5e-6 * np.round((place + 2e-6 * rng.standard_normal()) / 5e-6)
        last, error = error, reference[k] - position[k]
        drive[k] = np.clip(800.0 * error + 20.0 * (error - last) / dt, -10.0, 10.0)
        force = 20.0 * drive[k] - 60.0 * speed - 6.0 * np.tanh(speed / 1e-3)
        speed += dt * force / 2.0
        place += dt * speed
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    channels = {"time": time, "reference": reference, "position": position, "drive": drive}
    return Recording(channels, units)


def test_a_controller_that_answers_to_noise_is_no_fault(shivering):
    assert [each.text for each in check(shivering, Axis()) if each.level == "fault"] == []
