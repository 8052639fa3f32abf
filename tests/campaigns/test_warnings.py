"""What a diagnosis says of its recordings before it names anything."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns.campaign_file import read_campaign
from hannes.campaigns.periodicity import period
from hannes.campaigns.segments import noise_floors, split_campaign
from hannes.campaigns.warnings import campaign_warnings
from hannes.commands.diagnose import diagnose
from hannes.core.errors import BadInput
from hannes.core.recording.recording import Recording
from hannes.identification.holdout.decision import lacking
from hannes.plants.axis.plant import Axis

UNITS = {"time": "s", "reference": "m", "position": "m", "drive": "V"}


@functools.cache
def swing(seed, mass=96.0, seconds=4.0, noise=0.01):
    """An axis that swings once a second."""
    t = np.arange(round(seconds * 1000) + 1) / 1000.0
    reference = 0.05 * (1.0 - np.cos(2.0 * np.pi * t))
    bare = {"time": t, "reference": reference, "position": reference}
    run = Axis().simulate({"axis.mass": mass}, Recording(bare, {n: UNITS[n] for n in bare}))
    drive = run["drive"] + noise * np.random.default_rng(seed).standard_normal(t.size)
    return Recording({**bare, "position": run["position"], "drive": drive}, UNITS, plant="axis")


def campaign(folder, recordings, roles=None):
    rows = []
    for number, recording in enumerate(recordings):
        recording.write(folder / f"{number}.h5")
        role = f'role = "{roles[number]}"\n' if roles else ""
        rows.append(f'[[recording]]\nfile = "{number}.h5"\ncondition = "swings"\n{role}')
    (folder / "campaign.toml").write_text('plant = "axis"\n' + "".join(rows), encoding="utf-8")
    return folder / "campaign.toml"


def test_a_channel_off_by_a_factor_is_said_before_any_effect_is_named(tmp_path):
    runs = [swing(seed) for seed in range(4)]
    runs[2] = runs[2].with_channels({"drive": 1000.0 * runs[2]["drive"]}, {})
    with pytest.raises(BadInput, match=r"2\.h5: .*mV taken for V") as caught:
        diagnose(campaign(tmp_path, runs), out=tmp_path / "out")
    assert "\n" not in str(caught.value) and not (tmp_path / "out").exists()


def test_recordings_of_two_machines_give_a_warning(tmp_path):
    runs = [swing(seed, 96.0 if seed < 3 else 99.0, noise=0.002) for seed in range(6)]
    (warning,) = campaign_warnings(read_campaign(campaign(tmp_path, runs)))
    assert "two groups" in warning and "3.h5, 4.h5, 5.h5 are of another machine" in warning


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_recordings_of_one_machine_that_scatters_are_not_taken_for_two(tmp_path, spread):
    masses = 96.0 + spread * np.random.default_rng(1).standard_normal(6)
    runs = [swing(seed, mass, noise=0.002) for seed, mass in enumerate(masses)]
    assert campaign_warnings(read_campaign(campaign(tmp_path, runs))) == []


def test_a_command_that_repeats_gives_the_floor_and_the_cut(tmp_path):
    long = swing(0, seconds=20.0)
    assert period(Axis(), long) == 1000
    found = read_campaign(campaign(tmp_path, [long, swing(1, seconds=20.0)], ["fit", "show"]))
    pieces, note = split_campaign(found)
    assert "between two of 20 runs" in note
    assert [piece.role for piece in pieces] == ["fit", "select", "show"]
    assert pieces[1].recording.time[pieces[1].mask][0] == pytest.approx(10.0, abs=1e-9)
    known = [piece for piece in pieces if piece.role != "show"]
    floor, how = noise_floors(Axis(), known)
    assert floor["drive"] == pytest.approx(0.01, rel=0.1) and "whose command repeats" in how


def test_a_machine_of_which_all_is_uncertain_is_never_judged_on_half_a_run(tmp_path):
    """Its runs are fitted whole: a second half would be fitted, too, and hold nothing back."""
    found = read_campaign(campaign(tmp_path, [swing(0, seconds=20.0), swing(1)], ["fit", "show"]))
    plant = Axis()
    plant.uncertain = {"axis.mass": 1.0}
    pieces, note = split_campaign(replace(found, plant=plant))
    assert [piece.role for piece in pieces] == ["fit", "show"] and note == ""
    assert lacking(replace(found, plant=plant), pieces, ()).endswith("under the same command")
    assert lacking(found, pieces, ()).endswith(" s")


@pytest.mark.parametrize("rate", [0.37, 0.003])
def test_a_command_that_never_comes_back_has_no_period(rate):
    long = swing(0, seconds=20.0)
    t = long.time
    changed = long["reference"] * (1.0 + rate * np.sin(0.41 * t))
    assert period(Axis(), long.with_channels({"reference": changed}, {})) == 0


def test_another_input_that_does_not_repeat_spoils_the_period():
    long = swing(0, seconds=20.0)
    pulses = np.where(np.abs(long.time - 7.3) < 0.1, 5.0, 0.0)
    assert period(Axis(), long.with_channels({"pulses": pulses}, {"pulses": "V"})) == 0


def test_one_recording_alone_says_what_is_lacking(tmp_path):
    verdict = diagnose(campaign(tmp_path, [swing(0)], ["fit"])).verdict
    assert verdict.verdict == "undecided" and "record at least two more runs" in verdict.reason


def test_a_supply_that_falls_from_run_to_run(tmp_path, capsys):
    from hannes.commands.cli import main

    time = np.arange(300) / 300.0
    rng = np.random.default_rng(1)
    for k in range(5):
        asked = 4.0 * time
        supply = 12.0 - 0.15 * k + 0.01 * rng.standard_normal(300)
        channels = {"time": time, "reference": asked, "position": asked, "supply": supply}
        units = {"time": "s", "reference": "rad", "position": "rad", "supply": "V"}
        Recording(channels, units, "hand").write(tmp_path / f"{k}.csv")
    rows = [f'[[recording]]\nfile = "{k}.csv"\ncondition = "a"\n' for k in range(5)]
    (tmp_path / "campaign.toml").write_text("".join(rows), encoding="utf-8")
    main(["check", str(tmp_path / "campaign.toml")])
    said = capsys.readouterr().out
    assert "supply: falls by 0.6" in said and "battery" in said
    (tmp_path / "campaign.toml").write_text("".join(rows[:1] * 1), encoding="utf-8")
    main(["check", str(tmp_path / "campaign.toml")])
    assert "battery" not in capsys.readouterr().out
