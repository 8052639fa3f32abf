"""How late a motion is behind its command: known shifts come back, with intervals that hold."""

import clean
import numpy as np
import pytest

from hannes.campaigns.convert import convert
from hannes.core.errors import BadInput
from hannes.core.recording.time_lag import lag_behind

TIME = np.arange(2500) / 1000.0
ASKED = np.interp(TIME, [0.3, 1.1, 1.4, 2.0], [0.0, 10.0, 10.0, 0.0])


def late(shift, values=ASKED):
    """The values `shift` s later."""
    return np.interp(TIME - shift, TIME, values)


@pytest.mark.parametrize("shift", [0.0, 0.0123, -0.2, 0.31734])
def test_a_known_shift_comes_back(shift):
    found = lag_behind(TIME, late(shift), TIME, ASKED, 0.5)
    assert found.value == pytest.approx(shift, abs=1e-5)
    assert found.gain == pytest.approx(1.0, abs=1e-6) and found.correlation > 0.9999


def test_neither_offset_nor_scale_nor_other_sampling_matters():
    coarse = np.arange(0.05, 2.4, 0.007)
    motion = 3.0 + 0.4 * np.interp(coarse - 0.1, TIME, ASKED)
    found = lag_behind(coarse, motion, TIME, ASKED, 0.5)
    assert found.value == pytest.approx(0.1, abs=1e-3) and found.gain == pytest.approx(
        0.4, rel=0.01
    )


@pytest.mark.parametrize("noise", [1e-3, 2e-2])
def test_intervals_hold_the_truth_as_often_as_they_say(noise):
    """White noise, an encoder's counts, and a bump that the command does not have."""
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(200):
        shift = rng.uniform(-0.1, 0.1)
        motion = late(shift) + noise * rng.standard_normal(TIME.size)
        motion = np.round(motion / 1.5e-3) * 1.5e-3
        found = lag_behind(TIME, motion, TIME, ASKED, 0.3)
        inside += abs(found.value - shift) < 1.96 * found.deviation
    assert 180 <= inside <= 200


@pytest.mark.parametrize(
    ("motion", "command", "said"),
    [
        (0.0 * ASKED, ASKED, "the motion stands still"),
        (ASKED, 0.0 * ASKED, "the command stands still"),
        (-ASKED, ASKED, "sign reversed"),
        (np.sin(40.0 * TIME), ASKED, "does not follow"),
        (np.sin(40.0 * TIME), np.sin(40.0 * TIME), "several lags fit equally well"),
        (late(0.45), ASKED, "beyond 0.3 s"),
    ],
)
def test_what_cannot_be_aligned_is_refused(motion, command, said):
    with pytest.raises(BadInput, match=said):
        lag_behind(TIME, motion, TIME, command, 0.3)
    with pytest.raises(BadInput, match="too few"):
        lag_behind(TIME[:9], ASKED[:9], TIME, ASKED, 0.3)


MAPPING = """
{experiment}
time = {{ column = "time_s", unit = "s" }}
channels.position = {{ column = "position_rad", unit = "rad" }}
channels.current = {{ column = "current_A", unit = "A" }}
{more}
[align]
{align}
"""
REFERENCE = 'channels.reference = { column = "reference_rad", unit = "rad" }'


def aligned(folder, recording, align, experiment="", more=""):
    """The recording after a round trip through CSV and a mapping that aligns."""
    recording.write(folder / "log.csv")
    text = MAPPING.format(experiment=experiment, more=more, align=align)
    (folder / "map.toml").write_text(text, encoding="utf-8")
    (made,) = convert([folder / "log.csv"], folder / "map.toml")
    return made


@pytest.mark.parametrize("seed", [1, 2])
def test_a_reference_of_another_logger_is_moved_onto_the_motion(tmp_path, seed):
    """The hand simulated for it differs from the one recorded by two per cent throughout."""
    recording = clean.truth_closure(seed)
    moved = {
        name: np.interp(recording.time - 0.3137, recording.time, recording[name])
        for name in ("position", "current")
    }
    made = aligned(tmp_path, recording.with_channels(moved, {}), 'to = "reference"', more=REFERENCE)
    shift = made.report["shift"]
    assert abs(shift["value"] - 0.3137) < 2e-3
    assert shift["low"] < 0.3137 < shift["high"] and shift["high"] - shift["low"] < 0.02
    kept = made.recording
    there = np.interp(kept.time - 0.3137, recording.time, recording["reference"])
    assert kept.time[0] >= 0.31 and np.abs(kept["reference"] - there).max() < 0.05


def test_the_machines_own_lag_is_not_taken_for_a_shift(tmp_path):
    recording = clean.truth_closure()
    honest = aligned(tmp_path, recording, 'to = "reference"', more=REFERENCE).report["shift"]
    assert abs(honest["value"]) < 2e-3
    rule = 'to = "reference"\nby = "command"'
    naive = aligned(tmp_path, recording, rule, more=REFERENCE).report["shift"]
    assert 0.04 < naive["value"] < 0.08
    shift = aligned(tmp_path, recording, f'{rule}\nlag = "62 ms"', more=REFERENCE).report["shift"]
    assert abs(shift["value"]) < 2e-3


@pytest.mark.parametrize(("begin", "end"), [(0.0, 9.0), (0.25, 9.0), (0.0, 0.9)])
@pytest.mark.parametrize("clock", [100.0, -3.0])
def test_a_log_is_moved_onto_the_clock_of_its_experiment(tmp_path, begin, end, clock):
    """Begun late or ended early, on a clock that counts from anywhere."""
    recording = clean.shipped("full-closure").between(begin, end)
    away = recording.with_channels({"time": recording.time + clock}, {})
    rule = 'to = "experiment"\nwithin = "2 s"'
    made = aligned(tmp_path, away, rule, experiment='experiment = "full-closure"')
    assert made.report["shift"]["value"] == pytest.approx(clock, abs=1e-3)
    assert np.abs(made.recording.time - recording.time).max() < 1e-3
    assert "duration" in made.recording.experiment
