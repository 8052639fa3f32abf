"""The data check: what is planted in a clean recording is found; clean ones raise no alarm."""

import json

import clean
import numpy as np
import pytest
from real_finger import rh56_files

from hannes.campaigns import third_party
from hannes.campaigns.check import check, subjects
from hannes.campaigns.quality import clock, sensors
from hannes.campaigns.quality.finding import KINDS
from hannes.commands.cli import main
from hannes.core.errors import MissingRecording
from hannes.core.recording.recording import Recording
from hannes.plants.axis.plant import Axis
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.experiment import Experiment, Reference
from hannes.simulation.hand.hand import Hand
from hannes.simulation.sensors import observe
from hannes.simulation.simulate import simulate

CLOSURES = {
    "truth": clean.truth_closure,
    "full closure": lambda: clean.shipped("full-closure"),
    "grasp": lambda: clean.shipped("dynamometer"),
}
MOVING = {**CLOSURES, "axis": clean.swing}


def plant_of(recording):
    return Axis() if recording.plant == "axis" else HandPlant()


def found(recording, kind, channel, level=None):
    """Findings of a kind in a channel."""
    return [
        each
        for each in check(recording, plant_of(recording))
        if (each.kind, each.channel) == (kind, channel) and level in (None, each.level)
    ]


def scaled(recording, name, factor):
    return recording.with_channels({name: factor * recording[name]}, {})


def retimed(recording, time):
    return recording.with_channels({"time": time}, {})


def alarms(recording, plant):
    return [each for each in check(recording, plant) if each.level != "note"]


# --- clean recordings ---


@pytest.mark.parametrize("name", shipped.names())
@pytest.mark.parametrize("noisy", [True, False])
def test_shipped_experiments_raise_no_alarm(name, noisy):
    if name == "friction-curve":
        pytest.skip("simulates nothing")
    assert alarms(clean.shipped(name, noisy), HandPlant()) == []


@pytest.mark.slow
@pytest.mark.parametrize("run", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", [1, 2])
def test_closures_of_the_truth_raise_no_alarm(seed, run):
    assert alarms(clean.truth_closure(seed, run), HandPlant()) == []


@pytest.mark.parametrize("file", ["DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"])
def test_the_real_axis_raises_no_alarm(file):
    try:
        mapping = "emps-pulses" if "PULSES" in file else "emps"
        ((_, recording, _),) = subjects(third_party.folder("emps") / file, mapping=mapping)
    except MissingRecording as missing:
        pytest.skip(f"needs the EMPS recordings: {missing}")
    assert alarms(recording, Axis()) == []
    assert alarms(clean.swing(), Axis()) == []


@pytest.mark.parametrize("seed", [518, 827, 1216])
def test_four_equal_readings_on_a_noisy_round_peak_are_no_flat_top(seed, monkeypatch):
    """As steep at three samples from its top as noise of two steps makes it."""
    grasp = clean.shipped("dynamometer")
    count, rng = np.arange(len(grasp)), np.random.default_rng(seed)
    peak = 0.3 + 1.5 * np.exp(-0.5 * ((count - 600) / 15.0) ** 2)
    read = np.round((peak + 0.01 * rng.standard_normal(count.size)) / 0.005) * 0.005
    run = grasp.with_channels({"current": read}, {})
    assert np.diff(np.flatnonzero(read == read.max())).tolist() == [1, 1, 1]
    assert not found(run, "saturated", "current")
    monkeypatch.setattr(sensors, "SHORTEST_TOP", 4)
    assert found(run, "saturated", "current", "warning")


def test_slow_closures_of_a_rough_hand_raise_no_alarm():
    """Friction holds slow motion back by an angle, so by a third of a second where it is slow."""
    motion = Reference(np.array([[0.0, 4.247, 6.813], [0.0, 9.84, 0.0]]))
    hand = Hand().with_values({"motor.dry_friction": 6.5e-3})
    run = observe(hand, simulate(hand, Experiment("slow", 6.94, motion)))
    behind = run["reference"] - run["position"]
    assert behind[2000] > 0.2 * 9.84 / 4.247  # 0.2 s, all that a hand is granted where it is quick
    assert alarms(run, HandPlant()) == []


def test_real_finger_trials_have_gaps_and_no_fault(finger_trials):
    for trial in finger_trials:
        kinds = {(each.level, each.kind) for each in check(trial)}
        assert {level for level, _ in kinds} <= {"warning", "note"}
        # Its logger repeats whole readings for up to 90 ms while the finger moves on.
        known = {("warning", "gap"), ("warning", "held")}
        assert kinds <= known | {("note", "uneven"), ("note", "resolution")}


def test_real_finger_trials_have_no_fault_for_their_plant():
    """Its clock skips samples and shows it; a leap of its angle beside is no lost sample."""
    files = rh56_files("middlefinger_speed25_force1000_*.csv.gz")
    for name, trial, plant in subjects(files[0], mapping="rh56"):
        faults = [each.text for each in check(trial, plant) if each.level == "fault"]
        assert faults == [], name


@pytest.fixture(scope="module")
def finger_trials():
    """Twenty trials of each of some files of the RH56 finger: angle and force in raw counts."""
    files = rh56_files("middlefinger_*20trials*.csv.gz")
    return [trial for file in files[::8] for trial in _trials(file)]


def _trials(file):
    import gzip

    with gzip.open(file, "rt") as lines:
        names = lines.readline().strip().split(",")
        columns = [names.index(n) for n in ("Trial_Index", "Trial_Elapsed_s", "Middle_Angle", "Middle_Force_g")]  # fmt: skip  # noqa: E501
        table = np.loadtxt(lines, delimiter=",", usecols=columns)
    for trial in np.unique(table[:, 0]):
        _, time, angle, force = table[table[:, 0] == trial].T
        yield Recording(
            {"time": time, "angle": angle, "force": force},
            {"time": "s", "angle": "1", "force": "1"},
        )


# --- planted faults ---


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("share", [0.9, 0.7, 0.4])
def test_a_clipped_drive(name, share):
    recording = MOVING[name]()
    drive = "drive" if recording.plant == "axis" else "current"
    top = share * recording[drive].max()
    clipped = recording.with_channels({drive: np.minimum(recording[drive], top)}, {})
    lasting = np.count_nonzero(recording[drive] >= top) / 1000.0
    level = "fault" if lasting > 0.1 * len(recording) / 1000.0 else "warning"
    (finding,) = found(clipped, "saturated", drive, level)
    assert finding.size == pytest.approx(lasting, rel=0.5) and "clips" in finding.text


def test_a_drive_at_its_limit_is_only_noted():
    recording = clean.shipped("full-closure")
    duty = np.clip(2.0 * recording["duty"], -1.0, 1.0)
    loud = recording.with_channels({"duty": duty}, {})
    assert found(loud, "saturated", "duty", "note") and not found(
        loud, "saturated", "duty", "warning"
    )


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("lost", [1, 5, 40, 200])
def test_lost_samples_leave_a_gap(name, lost):
    recording = MOVING[name]()
    kept = np.delete(np.arange(len(recording)), np.arange(400, 400 + lost))
    holed = recording.with_channels({n: recording[n][kept] for n in recording.channels}, {})
    (finding,) = found(holed, "gap", "time", "warning")
    assert (
        finding.size == pytest.approx((lost + 1) / 1000.0)
        and f"{lost} samples lost" in finding.text
    )
    assert finding.time == pytest.approx(0.399)
    assert not found(holed, "jump", "position")


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize("lost", [20, 60])
def test_samples_lost_under_a_clock_that_runs_on(name, lost):
    recording = CLOSURES[name]()
    kept = np.delete(np.arange(len(recording)), np.arange(180, 180 + lost))
    holed = {n: recording[n][kept] for n in recording.channels}
    holed["time"] = recording.time[: kept.size]
    (finding,) = found(recording.with_channels(holed, {}), "lost", "time", "fault")
    assert f"some {lost} samples lost" in finding.text
    assert finding.time == pytest.approx(0.179)


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("drift", [0.004, -0.01, 0.05])
def test_a_clock_that_drifts_against_the_count_of_samples(name, drift):
    recording = MOVING[name]()
    count = np.arange(len(recording)) / len(recording)
    late = recording.time * (1.0 + 0.5 * drift * (count - 1.0))
    (finding,) = found(retimed(recording, late), "drift", "time", "warning")
    assert finding.size == pytest.approx(drift, rel=0.2)


@pytest.mark.parametrize("name", ["full closure", "grasp"])
@pytest.mark.parametrize("drift", [0.003, -0.006, 0.02, -0.05])
def test_a_clock_that_drifts_against_the_experiment(name, drift):
    recording = CLOSURES[name]()
    slow = retimed(recording, recording.time * (1.0 + drift))
    (finding,) = found(slow, "drift", "reference")
    assert finding.level == ("fault" if abs(drift) > 0.01 else "warning")
    assert finding.size == pytest.approx(drift, rel=0.1)


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("step", [0.03, -0.1, 0.4])
@pytest.mark.parametrize("lasting", [1, 10_000])
def test_an_encoder_that_jumps(name, step, lasting):
    """`step` is a share of the range; one sample off, or off from then on."""
    recording = MOVING[name]()
    position = recording["position"].copy()
    size = step * np.ptp(position)
    position[500 : 500 + lasting] += size
    (finding,) = found(
        recording.with_channels({"position": position}, {}), "jump", "position", "fault"
    )
    assert finding.time == pytest.approx(0.5) and abs(finding.size) == pytest.approx(
        abs(size), rel=0.3
    )


@pytest.mark.parametrize("name", MOVING)
def test_channels_that_never_move(name):
    recording = MOVING[name]()
    drive = "drive" if recording.plant == "axis" else "current"
    for channel in ("position", drive):
        for value in (0.0, 0.37):
            dead = recording.with_channels({channel: np.full(len(recording), value)}, {})
            (finding,) = found(dead, "dead", channel, "fault")
            assert "leave the channel out" in finding.text


@pytest.mark.parametrize("name", ["truth", "axis"])
@pytest.mark.parametrize("lasting", [30, 200])
def test_a_sensor_that_freezes(name, lasting):
    recording = MOVING[name]()
    drive = "drive" if recording.plant == "axis" else "current"
    values = recording[drive].copy()
    values[700 : 700 + lasting] = values[700]
    (finding,) = found(recording.with_channels({drive: values}, {}), "frozen", drive, "warning")
    assert finding.time == pytest.approx(0.7) and finding.size == pytest.approx(
        (lasting - 1) / 1000
    )


@pytest.mark.parametrize("factor", [180.0 / np.pi, 19.0])
@pytest.mark.parametrize(
    ("name", "power"),
    # no grasp with -1: a hand stopped by an object moves less than asked, too
    [("truth", 1), ("full closure", 1), ("grasp", 1), ("truth", -1), ("full closure", -1)],
)
def test_a_position_in_another_unit_than_its_reference(name, factor, power):
    recording = scaled(CLOSURES[name](), "position", factor**power)
    (finding, *_) = found(recording, "unit", "position", "fault")
    assert f"{factor:.4g}" in finding.text


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize("factor", [180.0 / np.pi, 19.0])
def test_position_and_reference_both_in_another_unit(name, factor):
    recording = scaled(scaled(CLOSURES[name](), "position", factor), "reference", factor)
    for channel in ("position", "reference"):
        (finding, *_) = found(recording, "unit", channel, "fault")
        assert f"{factor:.4g}" in finding.text


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_a_drive_in_thousandths(name, factor):
    drive = "drive" if MOVING[name]().plant == "axis" else "current"
    (finding,) = found(scaled(MOVING[name](), drive, factor), "unit", drive, "fault")
    assert finding.size == pytest.approx(factor) and "1000" in finding.text


def test_newtons_and_millinewtons():
    grasp = clean.shipped("dynamometer")
    assert found(scaled(grasp, "force", 1e3), "unit", "force", "fault")
    assert found(scaled(grasp, "force", 1e-3), "unit", "force", "warning")


def test_percent_for_a_share():
    (finding,) = found(scaled(clean.truth_closure(), "duty", 100.0), "unit", "duty", "fault")
    assert "percent" in finding.text


@pytest.mark.parametrize("name", MOVING)
def test_milliseconds_and_seconds(name):
    recording = MOVING[name]()
    (finding,) = found(retimed(recording, 1e3 * recording.time), "unit", "time", "fault")
    assert "milliseconds taken for seconds" in finding.text
    (finding,) = found(retimed(recording, 1e-3 * recording.time), "unit", "time", "fault")
    assert "seconds taken for milliseconds" in finding.text


def test_seconds_for_milliseconds_before_a_long_rest():
    beyond = np.zeros(101_000, dtype=bool)
    beyond[50:950] = True  # a closing
    assert clock._too_fast(beyond)
    spikes = np.zeros(101_000, dtype=bool)
    spikes[::1000] = spikes[1::1000] = True  # outliers of the position
    assert not clock._too_fast(spikes)


@pytest.mark.parametrize("name", MOVING)
def test_reversed_signs(name):
    recording = MOVING[name]()
    (finding, *_) = found(scaled(recording, "position", -1.0), "sign", "position", "fault")
    assert "reversed" in finding.text
    drive = "drive" if recording.plant == "axis" else "current"
    (finding,) = found(scaled(recording, drive, -1.0), "sign", drive)
    both_ways = name in ("truth", "axis")  # the others are closed alone, or helped open
    assert finding.level == ("fault" if both_ways else "warning") and "reversed" in finding.text


@pytest.mark.parametrize("name", CLOSURES)
def test_opening_counted_as_positive(name):
    recording = scaled(scaled(CLOSURES[name](), "position", -1.0), "reference", -1.0)
    for channel in ("position", "reference"):
        assert found(recording, "sign", channel, "fault")


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize("start", [0.1, 0.25])
def test_a_recording_that_begins_after_its_command(name, start):
    recording = CLOSURES[name]()
    (finding, *_) = found(recording.between(start, 9.0), "late-start", "position", "warning")
    assert finding.time == pytest.approx(start)


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize("late", [0.3, -0.1])
def test_a_reference_from_another_clock(name, late):
    recording = CLOSURES[name]()
    early = np.interp(recording.time + late, recording.time, recording["reference"])
    (finding, *_) = found(
        recording.with_channels({"reference": early}, {}), "late-start", "position"
    )
    assert finding.level == ("warning" if late > 0 else "fault") or finding.size > 0.0


@pytest.mark.parametrize("late", [0.3, -0.1])
def test_a_clock_that_is_not_the_experiments(late):
    grasp = clean.shipped("dynamometer")
    kept = {name: grasp[name] for name in ("position", "current")}
    units = {name: grasp.units[name] for name in ("time", *kept)}
    alone = Recording({"time": grasp.time + late, **kept}, units, experiment=grasp.experiment)
    (finding,) = found(alone, "late-start", "position")
    assert finding.level == ("warning" if late > 0 else "fault")
    assert finding.size == pytest.approx(late + 0.06, abs=0.05)


def test_noise_and_resolution_are_noted():
    recording = clean.truth_closure()
    (finding,) = found(recording, "resolution", "current", "note")
    assert finding.size == pytest.approx(0.0121, rel=0.1)
    (finding,) = found(recording, "resolution", "position", "note")
    assert f"step {2 * np.pi / 4096:.4g} rad" in finding.text
    coarse = np.round(recording["current"] / 0.05) * 0.05
    (finding,) = found(
        recording.with_channels({"current": coarse}, {}), "coarse", "current", "warning"
    )
    assert finding.size == pytest.approx(0.05)


# --- the command ---


def test_the_command_reports_and_refuses(tmp_path, capsys):
    recording = clean.shipped("dynamometer")
    recording.write(tmp_path / "good.h5")
    scaled(recording, "position", 57.29578).write(tmp_path / "bad.h5")
    assert main(["check", str(tmp_path / "good.h5")]) == 0
    assert "good.h5: 0 faults, 0 warnings" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "good.h5"), str(tmp_path / "bad.h5"), "--json"]) == 2
    printed = capsys.readouterr()
    (line,) = printed.err.splitlines()
    assert "bad.h5: not sound" in line
    good, bad = json.loads(printed.out)["recordings"]
    assert good["file"].endswith("good.h5")
    assert "degrees" in bad["findings"][0]["text"]
    assert {each["level"] for each in good["findings"]} == {"note"}
    assert set(bad["findings"][0]) == {
        "level", "kind", "channel", "text", "time", "size", "mend"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.csv"], "no such file"),
        (["nothing.txt"], "expected a recording named"),
        (["run.csv", "--plant", "hnd"], 'did you mean "hand"'),
        (["run.csv", "--plant", "axis"], "name another plant with --plant"),
        (["run.csv", "--experiment", "void-closur"], 'did you mean "void-closure"'),
    ],
)
def test_what_cannot_be_checked_is_one_line(tmp_path, capsys, monkeypatch, words, said):
    (tmp_path / "run.csv").write_text("time_s,current_A\n0,1\n1,2\n2,3\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["check", *words]) == 2
    printed = capsys.readouterr()
    (line,) = printed.err.splitlines()
    assert said in line and printed.out == ""


SHAPES = (
    lambda rng, n: np.zeros(n),
    lambda rng, n: np.full(n, 3.3),
    lambda rng, n: rng.standard_normal(n),
    lambda rng, n: np.cumsum(rng.standard_normal(n)),
    lambda rng, n: np.round(rng.standard_normal(n)),
    lambda rng, n: np.sin(rng.uniform(1.0, 50.0) * np.arange(n) / n),
    lambda rng, n: np.where(np.arange(n) > n // 2, 1.0, 0.0),
    lambda rng, n: np.exp(np.linspace(0.0, 15.0, n)),
    lambda rng, n: 1e-300 * rng.standard_normal(n),
)


@pytest.mark.parametrize("seed", range(60))
def test_the_check_itself_never_fails_whatever_it_is_given(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.choice([2, 3, 5, 22, 43, 300]))
    time = np.cumsum(rng.uniform(0.5, 2.0, count)) * 10.0 ** rng.integers(-6, 4)
    units = clean.shipped("dynamometer").units
    channels = {name: SHAPES[rng.integers(len(SHAPES))](rng, count) for name in units}
    channels = {name: x * 10.0 ** rng.integers(-5, 6) for name, x in channels.items()}
    experiment = clean.shipped("dynamometer").experiment if seed % 2 else ""
    recording = Recording({**channels, "time": time}, units, experiment=experiment)
    for plant in (HandPlant(), None):
        found = check(recording, plant)
        assert all("\n" not in str(each) and each.kind in KINDS for each in found)
