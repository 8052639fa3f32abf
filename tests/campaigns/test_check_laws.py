"""What only the law of a drive shows: ranges, slips, trips, leaks, another pace of a servo."""

import tomllib
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.intake import sound
from benchmarks.intake.bases import Logger, base, logged
from benchmarks.intake.case import case
from benchmarks.intake.mapped import recordings, sound_mapping
from benchmarks.intake.servo_plant import Servo
from benchmarks.truth import servo
from benchmarks.truth.campaign import make
from benchmarks.truth.protocol import DYNAMOMETER, PAPER, POOR, RICH, Condition, Protocol, scaled
from hannes.campaigns.begin.mapping_text import _expression
from hannes.campaigns.check import check
from hannes.campaigns.convert import convert
from hannes.campaigns.foreign.raw_values import disorder
from hannes.campaigns.quality.breaks import _is_seen
from hannes.campaigns.quality.law import Relation
from hannes.campaigns.quality.law_break import Break
from hannes.core.recording.recording import Recording
from hannes.plants.hand.plant import HandPlant

TIME = np.arange(3000) / 1000.0
UNITS = {"time": "s", "reference": "rad", "position": "rad", "current": "A"}
STEPS = {"position": 2.0 * np.pi / 16384, "current": 2e-3}


@cache
def moved():
    marks = np.array([0.0, 0.3, 0.9, 1.2, 1.8, 2.1, 2.7, 3.0])
    goals = np.array([0.0, 0.0, 0.8, 0.8, -0.5, -0.5, 0.3, 0.3])
    place = np.clip(np.searchsorted(marks, TIME, side="right") - 1, 0, marks.size - 2)
    share = (TIME - marks[place]) / np.diff(marks)[place]
    asked = goals[place] + np.diff(goals)[place] * share**3 * (10 - 15 * share + 6 * share**2)
    run = servo.simulate(servo.SERVO, asked)
    return {"reference": asked, "position": run["position"], "current": run["drive"]}


def columns(**changed):
    """A log: noise on the current, both sensors with steps."""
    found = {**moved(), **changed}
    noise = 5e-3 * np.random.default_rng(1).standard_normal(TIME.size)
    found["current"] = found["current"] + noise
    for name, step in STEPS.items():
        found[name] = step * np.round(found[name] / step)
    return {"time": TIME[: found["position"].size], **found}


def serious(channels):
    found = check(Recording(channels, UNITS, "servo"), Servo())
    return [each for each in found if each.level != "note"]


def test_a_sound_log_has_nothing_serious():
    assert serious(columns()) == []


@pytest.mark.parametrize("factor", [0.8, 1.25, 10.0])
def test_a_range_that_was_switched(factor):
    log = columns()
    log["current"] = np.where(TIME > 1.4, factor, 1.0) * log["current"]
    (found,) = serious(log)
    assert (found.kind, found.channel) == ("range", "current")
    assert found.time == pytest.approx(1.4, abs=0.2) and found.mend[0].startswith("time.cut")


def test_an_encoder_that_slips():
    q = moved()["position"]
    missed = np.where((TIME > 0.4) & (TIME < 0.7), np.gradient(q), 0.0)
    (found,) = serious(columns(position=q - 0.15 * np.cumsum(missed)))
    assert (found.kind, found.channel) == ("slip", "position") and found.time < 0.5


def test_a_stage_that_trips_near_the_end_of_a_stroke():
    run, start = moved(), 850
    position, current = run["position"].copy(), run["current"].copy()
    position[start:], current[start:] = position[start], 0.0
    found = serious(columns(position=position, current=current))
    assert [each.kind for each in found] == ["disabled"]
    assert found[0].time == pytest.approx(0.85, abs=0.02)


@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_drive_that_leaks_into_the_encoder(share):
    log = columns()
    log["position"] = log["position"] + share * log["current"]
    (found,) = serious(log)
    assert (found.kind, found.channel) == ("crosstalk", "position")
    assert found.size == pytest.approx(share, rel=0.1)


def test_a_speed_that_was_overridden():
    slow = {n: np.interp(0.96 * TIME, TIME, x) for n, x in moved().items() if n != "reference"}
    (found,) = serious(columns(**slow))
    assert found.kind == "pace" and found.size == pytest.approx(1.0 / 0.96, rel=3e-3)


def test_a_zero_smaller_than_a_motion_alone_shows():
    (found,) = serious(columns(position=moved()["position"] + 0.01))
    assert found.kind == "zero"
    assert found.mend[0].startswith('channels.position.offset = "-0.0')


def test_rows_lost_in_motion():
    kept = np.delete(np.arange(TIME.size), np.arange(600, 612))
    log = {name: x[kept] for name, x in columns().items()}
    (found,) = serious({**log, "time": TIME[: kept.size]})
    assert found.kind == "lost" and "some 12 samples" in found.text


def test_a_slow_command_in_whole_counts_has_lost_nothing():
    log = columns()
    steps = np.resize([1.0, 1.0, 1.0, 2.0], TIME.size) * (np.abs(TIME - 1.5) < 0.4)
    log["reference"] = 1e-3 * np.cumsum(steps)
    assert "lost" not in [each.kind for each in serious(log)]


MAPPING = """plant = "hand"
missing = ["n/a"]
[time]
column = "t"
unit = "s"
cut = [["0.1 s", "0.12 s"]]
[channels.reference]
column = "ref"
unit = "rad"
[channels.position]
column = "pos"
unit = "rad"
scale = 2.0
offset = "0.5 rad"
[channels.current]
column = "cur"
unit = "A"
reversed = true
"""


def test_a_mend_goes_on_from_what_the_mapping_has(tmp_path):
    run = moved()
    pushed = np.tanh(np.gradient(run["position"], TIME))
    np.savez(tmp_path / "log.npz", t=TIME, ref=10.0 * np.abs(run["reference"]), cur=pushed,
             pos=5.0 * np.abs(run["position"]) - 0.25)  # fmt: skip
    (tmp_path / "map.toml").write_text(MAPPING)
    (made,) = convert([tmp_path / "log.npz"], tmp_path / "map.toml")
    from hannes.campaigns.quality import mends
    from hannes.campaigns.quality.subject import Subject

    subject = Subject(made.recording)
    lines = (
        *mends.scaled(subject, "position", 4.0),
        *mends.reversed_sign(subject, "current"),
        *mends.cut(subject, [(0, 3)]),
        *mends.missing(subject, ["-999"]),
    )
    said = tomllib.loads("\n".join(lines))
    assert said["channels"]["position"] == {"scale": 0.5, "offset": "0.125 rad"}
    assert said["channels"]["current"] == {"reversed": False}
    assert said["time"]["cut"][0] == ["0.1 s", "0.12 s"] and len(said["time"]["cut"]) == 2
    assert said["missing"] == ["n/a", "-999"]


def test_lines_to_skip_do_not_begin_as_samples_do():
    import re

    samples = ["2026-03-03 18:43:13.2, 1.0", "2026-03-03 18:43:13.3, 1.1"]
    pattern = re.compile(_expression(["2026-03-03 rebooted", "# note"], samples))
    assert not any(map(pattern.search, samples))
    assert pattern.search("2026-03-03 rebooted") and pattern.search("# note")


def test_a_clock_that_was_set_back_is_not_out_of_order():
    time = np.r_[TIME[:300], TIME[300:] - 0.1]
    assert disorder(time)[1] == 'time.sampling = "1000 Hz"'
    assert disorder(TIME[np.r_[:30, 31, 30, 32:600]])[1] == 'time.order = "sort"'


@pytest.mark.parametrize("seed", [500013, 500020])
def test_an_encoder_that_turns_not_at_all_for_a_while(seed):
    row = case("encoder hub slips", "gross", seed)
    assert row["size"] == 1.0 and row["found"] and row["named"]


def hand(time, position):
    """A hand's log without its command."""
    channels = {"time": time, "position": 2.0 * np.pi / 4096 * np.round(position / (np.pi / 2048))}
    return check(Recording(channels, {"time": "s", "position": "rad"}, "hand"), HandPlant())


def test_samples_lost_from_a_slow_motion():
    time = np.arange(6000) / 1000.0
    position = np.interp(time, (0.0, 0.3, 2.9, 3.1, 5.7), (0.0, 0.0, 4.0, 4.0, 0.0))
    assert [each for each in hand(time, position) if each.level != "note"] == []
    left = np.delete(position, slice(1500, 1518))
    found = [each for each in hand(time[: left.size], left) if each.level != "note"]
    assert [each.kind for each in found] == ["lost"]
    assert found[0].time == pytest.approx(1.5, abs=2e-3) and found[0].size == pytest.approx(
        18, abs=2
    )


@pytest.mark.parametrize("run", [4, 10])
def test_a_coarse_encoder_is_not_called_slipping(tmp_path, run):
    machine = base("hand", run)
    log = logged(machine, Logger(bits=8), True, np.random.default_rng(run))
    (made,) = recordings(machine, log, sound_mapping(machine, log), tmp_path)
    assert [each.kind for each in check(made.recording, HandPlant()) if each.level == "fault"] == []


def test_a_drive_at_rest_beside_a_gap_is_not_called_off():
    assert sound.case(310344)["faults"] == []


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        ("spikes of position", 600000),  # no wrong unit of time
        ("probe range switched", 600000),  # no drive that is off
        ("counter overflows", 600002),
        ("motion of another run", 600002),
    ],
)
def test_faults_that_were_taken_for_others(name, seed):
    row = case(name, "gross", seed)
    assert row["found"] and row["named"] and row["mended"]


def test_a_current_that_is_clipped_is_no_slipping_encoder():
    grasp = Condition("dynamometer", PAPER, 1, DYNAMOMETER, sensor=True)
    hidden = {"clipped_current.inverse_range": 1.15, "current_offset.offset": -0.024}
    made = make(Protocol((grasp,), RICH), 5, hidden)
    (recording,) = made.recordings.values()
    found = check(recording, HandPlant())
    assert "slip" not in [each.kind for each in found]


@pytest.mark.parametrize("channels", [POOR, RICH])
def test_a_machine_that_lags_less_and_less_was_not_overridden(channels):
    """Its grease warms: by its motion alone a slow closure seems 3 % faster than its command."""
    slow = Condition("void, 0.15 speed", scaled(PAPER, 0.15), 1)
    made = make(Protocol((slow,), channels), 3, {"warming_grease.fall": 0.37})
    (recording,) = made.recordings.values()
    assert [each.kind for each in check(recording, HandPlant()) if each.level == "fault"] == []


def test_a_machine_on_a_weak_supply_was_not_overridden():
    """Its current's law alone seems to hold at another pace."""
    grasp = Condition("dynamometer", PAPER, 1, DYNAMOMETER, sensor=True)
    made = make(Protocol((grasp,), RICH), 5, {"supply_sag.resistance": 0.854})
    (recording,) = made.recordings.values()
    assert [each.kind for each in check(recording, HandPlant()) if each.level == "fault"] == []


def test_a_current_that_loses_more_one_way_is_no_switched_range():
    """Its driver is dead for a while at each edge, and its supply sags: less is left of a pull."""
    slow = Condition("dynamometer, 0.25 speed", scaled(PAPER, 0.25), 1, DYNAMOMETER, sensor=True)
    hidden = {"bridge_dead_time.share": 0.04, "supply_sag.resistance": 0.72}
    made = make(Protocol((slow,), RICH), 5, hidden)
    (recording,) = made.recordings.values()
    assert "range" not in [each.kind for each in check(recording, HandPlant())]


@pytest.mark.parametrize("rested", [0, 300])  # samples before the command begins
def test_a_drive_that_crosses_zero_while_a_machine_begins_to_follow_is_not_off(rested):
    hidden = {"current_offset.offset": -0.048}
    made = make(Protocol((Condition("void", PAPER, 6),), POOR), 5, hidden)
    for one in made.recordings.values():
        found = check(after_rest(one, rested), HandPlant())
        assert "disabled" not in [each.kind for each in found]


def after_rest(recording, count):
    """The recording with samples of rest before it, its current as noisy as it is."""
    noise = 0.007 * np.random.default_rng(1).standard_normal(count)
    first = {name: np.full(count, each[0]) for name, each in recording.channels.items()}
    first["current"] = 0.005 * np.round((noise - 0.048) / 0.005)
    channels = {n: np.concatenate((first[n], each)) for n, each in recording.channels.items()}
    interval = recording.time[1] - recording.time[0]
    channels["time"] = interval * np.arange(recording.time.size + count)
    return replace(recording, channels=channels)


@pytest.mark.parametrize(("of", "seen"), [("current", False), ("duty", True)])
def test_a_duty_at_its_end_hides_no_slip(of, seen):
    drive = np.concatenate([np.linspace(0.0, 1.0, 50), np.ones(100)])
    columns, time = np.zeros((150, 2)), np.arange(150) / 150.0
    law = Relation("controller", of, drive, columns, time, True, time, np.arange(150))
    found = Break("slip", 60, 90, 0.2, 0.99, 0.01, 0.2)
    drives = SimpleNamespace(drives="position")
    subject = SimpleNamespace(of=lambda name: drives, recording={"position": time})
    assert _is_seen(subject, law, found) is seen
