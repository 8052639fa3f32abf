"""A finger on a fixed object: closed forms, its effects, its logs, and what a diagnosis names."""

import gzip
import json
import re

import numpy as np
import pytest

from hannes.campaigns import third_party
from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.check import subjects
from hannes.campaigns.convert import convert
from hannes.commands.cli import main
from hannes.commands.diagnose import diagnose
from hannes.core.errors import BadInput, MissingRecording
from hannes.core.recording.recording import Recording
from hannes.plants.finger.plant import Finger
from hannes.plants.plant_file import load_model
from hannes.plants.protocol import Plant, find_plant

TRUE = {"contact.stiffness": 5500.0, "contact.angle": 6.97, "contact.exponent": 1.9}
LOGS = 'plant = "finger"\n[[recording]]\nmapping = "rh56"\n'
HEAD = "Trial_Index,Trial_Elapsed_s,Commanded_Speed,Middle_Angle,Middle_Force_g,Middle_Force_N"


def closing(seed=0, first=0.0):
    """4 s: open, closed onto the object at some speed, let go; uneven samples of whole counts."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.012, 0.014, 300))
    time -= time[0]
    speed, depth = rng.uniform(150.0, 900.0), rng.uniform(640.0, 670.0)
    angle = np.clip(1000.0 - speed * (time - 0.5), depth, 1000.0)
    opening = np.clip(depth + 900.0 * (time - 2.8), depth, 1000.0)
    angle = np.round(np.where(time > 2.8, opening, angle))
    channels = {"time": time, "angle": angle, "force": np.full(time.size, first)}
    return Recording(channels, {"time": "s", "angle": "1", "force": "1"}, plant="finger")


def simulated(recording, values, *names, noise=0.0, seed=0):
    """The recording with the force that a finger with these effects logs."""
    plant = Finger().with_effects(*(Finger.catalogue[name] for name in names))
    force = plant.simulate(values, recording)["force"]
    force = np.round(force + noise * np.random.default_rng(seed).standard_normal(force.size))
    return recording.with_channels({"force": force}, {})


def test_the_finger_is_a_plant_with_a_catalogue_of_its_own():
    plant = find_plant("finger")
    assert isinstance(plant, Plant) and all(
        plant.accepts(e) == "" for e in plant.catalogue.values()
    )


def test_its_effects_are_listed_and_described(capsys):
    assert main(["effects", "--plant", "finger"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in Finger.catalogue) and "leader_slack" not in listed
    assert main(["effects", "reading_delay", "--plant", "finger"]) == 0
    assert "reported late by a fixed time" in capsys.readouterr().out


def test_the_contact_is_a_power_of_depth_and_never_pulls():
    recording = closing()
    found = Finger().simulate(TRUE, recording)["force"]
    depth = np.maximum(6.97 - recording["angle"] / 100.0, 0.0)
    assert found == pytest.approx(5500.0 * depth**1.9, rel=1e-12) and found.min() == 0.0


@pytest.mark.parametrize("name", sorted(Finger.catalogue))
def test_an_effect_at_off_changes_nothing_and_leaves_a_mark_otherwise(name):
    effect, recording = Finger.catalogue[name], closing()
    plant = Finger().with_effects(effect)
    assert np.array_equal(*(p.simulate({}, recording)["force"] for p in (Finger(), plant)))
    for each in effect.amplitudes:
        size = 0.2 * each.bounds[1]
        moved = plant.simulate({effect.full_name(each.name): size}, recording)["force"]
        assert np.abs(moved - Finger().simulate({}, recording)["force"]).max() > 10.0


def test_a_lagging_reading_of_an_open_finger_decays_exactly():
    recording = closing(first=800.0)
    open_ = recording.time < 0.5
    plant = Finger().with_effects(Finger.catalogue["force_lag"])
    found = plant.simulate({"force_lag.time": 0.142}, recording)["force"][open_]
    assert found == pytest.approx(800.0 * np.exp(-recording.time[open_] / 0.142), rel=1e-4)


def test_a_delay_reads_the_angle_of_before():
    recording = closing()
    plant = Finger().with_effects(Finger.catalogue["reading_delay"])
    late = plant.simulate({**TRUE, "reading_delay.time": 0.1}, recording)["force"]
    before = np.interp(recording.time - 0.1, recording.time, recording["angle"])
    depth = np.maximum(6.97 - before / 100.0, 0.0)
    assert late == pytest.approx(5500.0 * depth**1.9, rel=1e-9)


def test_a_creeping_contact_relaxes_as_its_closed_form_does():
    """Pressed at once and held: F = F_e (1 + share exp(-t / time))."""
    time = np.arange(0.0, 1.0, 0.01)
    angle = np.where(time < 0.005, 1000.0, 650.0)
    channels = {"time": time, "angle": angle, "force": 0.0 * time}
    recording = Recording(channels, {"time": "s", "angle": "1", "force": "1"})
    plant = Finger().with_effects(Finger.catalogue["creeping_contact"])
    values = {**TRUE, "creeping_contact.share": 0.4, "creeping_contact.time": 0.2}
    found = plant.simulate(values, recording)["force"][1:]
    rest = 5500.0 * 0.47**1.9
    assert found == pytest.approx(rest * (1.0 + 0.4 * np.exp(-time[1:] / 0.2)), rel=1e-4)


def campaign(folder, values, *names):
    """Path of a campaign of twelve closings that a finger with these effects made."""
    rows = []
    for seed, role in enumerate(["fit"] * 6 + ["select"] * 3 + ["show"] * 3):
        simulated(closing(seed), values, *names, noise=2.0, seed=seed).write(folder / f"{seed}.csv")
        rows.append(f'[[recording]]\nfile = "{seed}.csv"\nrole = "{role}"\n')
    (folder / "campaign.toml").write_text('plant = "finger"\n' + "".join(rows), encoding="utf-8")
    return folder / "campaign.toml"


@pytest.mark.parametrize(
    ("name", "parameter", "size"),
    [
        ("force_lag", "time", 0.12),
        ("reading_delay", "time", 0.09),
        ("creeping_contact", "share", 0.3),
        ("hunt_crossley", "damping", 0.1),
    ],
)
def test_each_effect_is_distinguished_from_the_others(tmp_path, name, parameter, size):
    full = f"{name}.{parameter}"
    found = diagnose(campaign(tmp_path, {**TRUE, full: size}, name), out=tmp_path / "out")
    assert found.verdict.effects == [name] and found.verdict.verdict.startswith("named")
    assert found.verdict.parameters[full]["value"] == pytest.approx(size, rel=0.1)
    assert "sample-to-sample roughness, because there are no repeats" in found.verdict.summary()
    assert load_model(str(tmp_path / "out" / "hand.toml")).effects == found.plant.effects


def test_a_finger_with_nothing_hidden_is_only_calibrated(tmp_path):
    verdict = diagnose(campaign(tmp_path, TRUE)).verdict
    assert verdict.effects == [] and verdict.verdict in ("no_gap", "recalibrated")


def log(
    folder, trials=(1, 2, 3, 4, 5, 6, 7), name="middlefinger_speed250_force500_20trials_a.csv.gz"
):
    """A log of a hand: the same closing again and again."""
    recording = closing()
    rows = [HEAD]
    for trial in trials:
        for row in zip(recording.time, recording["angle"], recording["force"], strict=True):
            time, angle, force = row
            rows.append(f"{trial},{time:.6f},250,{angle:.0f},{force:.0f},{force:.4f}")
    (folder / name).write_bytes(gzip.compress("\n".join(rows).encode()))
    return folder / name


def test_a_log_is_cut_into_its_trials(tmp_path):
    runs = convert([log(tmp_path)], "rh56")
    assert [each.number for each in runs] == list(range(1, 8))
    assert all(len(each.recording) == 300 for each in runs)
    assert all(each.recording["angle"][0] == 1000.0 for each in runs)


@pytest.mark.parametrize(("runs", "kept"), [("1::5", [2, 7]), ("3::5", [4]), (":2", [1, 2])])
def test_a_campaign_chooses_runs_of_a_file(tmp_path, runs, kept):
    log(tmp_path)
    text = f'{LOGS}file = "*.csv.gz"\nruns = "{runs}"\nrole = "fit"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    names = [each.name for each in read_campaign(tmp_path / "mine.toml").entries]
    assert [int(name.rpartition(" ")[2]) for name in names] == kept


@pytest.mark.parametrize(
    ("runs", "said"), [("odd", "start:stop:step"), ("1::0", "start:stop:step"), ("9:", "no run")]
)
def test_runs_that_cannot_be_chosen_are_one_line(tmp_path, runs, said):
    log(tmp_path)
    text = f'{LOGS}file = "*.csv.gz"\nruns = "{runs}"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=re.escape(said)):
        read_campaign(tmp_path / "mine.toml")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Middle_Angle", "Angle", 'no column "Middle_Angle"'),
        (",1000,0,0.0000", ",x,0,0.0000", "line 2"),
        ("0.000000", "9.000000", "time"),
    ],
)
def test_a_log_that_is_none_is_one_line(tmp_path, old, new, said):
    file = log(tmp_path, (1,))
    text = gzip.decompress(file.read_bytes()).decode()
    assert old in text
    file.write_bytes(gzip.compress(text.replace(old, new, 1).encode()))
    with pytest.raises(BadInput, match=said) as caught:
        convert([file], "rh56")
    assert "\n" not in str(caught.value) and file.name in str(caught.value)


def test_trials_of_one_log_are_repeats_and_two_logs_of_one_name_keep_apart(tmp_path):
    for day in ("monday", "tuesday"):
        (tmp_path / day).mkdir()
        log(tmp_path / day, (1, 2))
    text = f'{LOGS}file = "*/*.csv.gz"\nrole = "fit"\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    found = read_campaign(tmp_path / "mine.toml").entries
    days = [each.condition.partition("/")[0] for each in found]
    assert days == ["monday", "monday", "tuesday", "tuesday"]
    assert len({each.condition for each in found}) == 2 and len({each.name for each in found}) == 4


def test_a_log_in_another_encoding_is_one_line(tmp_path):
    file = log(tmp_path, (1,))
    text = gzip.decompress(file.read_bytes())
    file.write_bytes(gzip.compress(text.replace(b",250,", b",\xb5250,", 1)))
    with pytest.raises(BadInput, match="not utf-8 text") as caught:
        convert([file], "rh56")
    assert file.name in str(caught.value)


def test_the_check_reads_a_log_through_its_mapping(tmp_path):
    file = log(tmp_path, (1, 2))
    found = subjects(file, mapping="rh56")
    assert [name for name, *_ in found] == [f"{file.name}, run {k}" for k in (1, 2)]
    with pytest.raises(BadInput, match="leave --plant out"):
        subjects(file, "finger", mapping="rh56")
    (tmp_path / "c.toml").touch()
    with pytest.raises(BadInput, match="leave them out"):
        subjects(tmp_path / "c.toml", "finger")


@pytest.mark.slow
def test_the_real_finger_lags_in_its_reading(tmp_path, capsys):
    """One command of the 35; benchmarks.real_machines judges all of them."""
    try:
        folder = third_party.folder("rh56_finger")
    except MissingRecording as missing:
        pytest.skip(f"needs the RH56 recordings: {missing}")
    (file,) = folder.glob("middlefinger_speed250_force500_20trials_*.csv*")
    parts = (("0::2", "fit"), ("1::4", "select"), ("3::4", "show"))
    rows = [
        f'[[recording]]\nmapping = "rh56"\nfile = "{file.as_posix()}"\nruns = "{runs}"\n'
        f'role = "{role}"\n'
        for runs, role in parts
    ]
    (tmp_path / "c.toml").write_text('plant = "finger"\n' + "".join(rows), encoding="utf-8")
    assert (
        main(["diagnose", str(tmp_path / "c.toml"), "--out", str(tmp_path / "out"), "--json"]) == 0
    )
    verdict = json.loads(capsys.readouterr().out)
    assert verdict["effects"] == ["force_lag"]
    assert 0.13 < verdict["parameters"]["force_lag.time"]["value"] < 0.16
    assert any("gaps" in each for each in verdict["cautions"])
