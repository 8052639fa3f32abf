"""Gross mistakes that pass for data: another clock, another run, a magnitude, held samples."""

import numpy as np
import pytest

from hannes.campaigns.check import check
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.experiment.reader import experiment_text

TIME = np.round(0.001 * np.arange(1150), 9)
COMMAND = np.interp(TIME, [0.0, 0.637, 1.022], [0.0, 9.84, 0.0])
ENCODER, STEP = 2.0 * np.pi / 4096, 0.003
UNITS = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}


def position(lag=0.06):
    return ENCODER * np.round(np.interp(TIME - lag, TIME, COMMAND, left=0.0) / ENCODER)


def current(seed=1):
    speed = np.gradient(np.interp(TIME - 0.06, TIME, COMMAND, left=0.0), TIME)
    noise = 0.008 * np.random.default_rng(seed).standard_normal(TIME.size)
    return STEP * np.round((0.3 * np.tanh(speed) + 0.4 * (COMMAND / 9.84) ** 6 + noise) / STEP)


def recording(experiment="", **changed):
    channels = {"reference": COMMAND, "position": position(), "current": current(), **changed}
    channels = {name: values for name, values in channels.items() if values is not None}
    time = channels.pop("time", TIME)
    units = {name: UNITS[name] for name in ("time", *channels)}
    return Recording({"time": time, **channels}, units, "hand", experiment=experiment)


def serious(made):
    return [(each.level, each.kind, each.channel) for each in check(made, HandPlant())
            if each.level != "note"]  # fmt: skip


def dynamometer():
    return experiment_text("dynamometer")


def test_a_sound_recording_has_nothing_serious():
    assert serious(recording()) == []
    assert serious(recording(dynamometer(), reference=None)) == []


@pytest.mark.parametrize("later", [1.0, 3.0, 10.0, 1_764_141_133.0])
def test_another_clock_than_the_experiments(later):
    found = serious(recording(dynamometer(), reference=None, time=TIME + later))
    assert found in ([("fault", "clock", "time")], [("fault", "late-start", "position")])


def test_another_experiment_than_was_made():
    found = serious(recording(experiment_text("full-closure"), reference=None))
    assert found == [("fault", "unlike", "position")]


def test_a_position_that_never_moves():
    found = serious(recording(dynamometer(), reference=None, position=np.zeros(TIME.size)))
    assert found == [("fault", "dead", "position")]


def test_a_column_that_is_no_motion_of_this_command():
    other = np.cumsum(np.random.default_rng(2).standard_normal(TIME.size)) * 0.1
    assert ("fault", "unlike", "position") in serious(recording(position=other))


def test_the_magnitude_of_a_current():
    assert serious(recording(current=np.abs(current()))) == [("fault", "magnitude", "current")]


@pytest.mark.parametrize("share", [0.7, 0.9])
def test_a_clipped_current_by_the_length_of_its_top(share):
    values = current()
    clipped = np.minimum(values, STEP * np.round(share * values.max() / STEP))
    (found,) = [each for each in check(recording(current=clipped), HandPlant())
                if each.kind == "saturated"]  # fmt: skip
    assert found.channel == "current" and found.size > 0.02


def test_a_logger_that_repeats_whole_frames():
    rows = np.arange(TIME.size)
    for start in (100, 250, 400, 700, 850):
        rows[start : start + 6] = start
    found = serious(recording(position=position()[rows], current=current()[rows]))
    assert found == [("warning", "held", "time")]


@pytest.mark.parametrize("period", [5, 10])
def test_values_renewed_less_often_than_logged(period):
    rows = np.arange(TIME.size) // period * period
    found = serious(recording(position=position()[rows], current=current()[rows]))
    assert found == [("warning", "held", "position")]


def test_stamps_that_jitter_are_no_lost_samples():
    moved = 0.01 * np.arange(115) + np.random.default_rng(3).uniform(-0.0045, 0.0045, 115)
    channels = {
        n: np.interp(moved, TIME, x) for n, x in recording().channels.items() if n != "time"
    }
    made = Recording({"time": moved - moved[0], **channels}, UNITS, "hand")
    assert not [each for each in check(made, HandPlant()) if each.kind == "gap"]
    kept = np.delete(np.arange(115), [40, 41, 42, 80])
    made = Recording(
        {"time": (moved - moved[0])[kept], **{n: x[kept] for n, x in channels.items()}},
        UNITS,
        "hand",
    )
    (gap,) = [each for each in check(made, HandPlant()) if each.kind == "gap"]
    assert "4 samples lost" in gap.text


def test_what_a_plant_requires_and_does_not_judge_is_a_command():
    class Lamp(HandPlant):
        required = ("current",)
        judged = ("position",)

    stepped = np.where(TIME > 0.5, 1.0, 0.0)
    made = recording(reference=None, current=stepped)
    assert not [each for each in check(made, Lamp()) if each.channel == "current" and
                each.kind in ("jump", "saturated", "frozen")]  # fmt: skip
