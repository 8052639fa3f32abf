"""What a finding says mends a file: its mapping lines, tried; and real machines by a mapping."""

import os
from pathlib import Path

import numpy as np
import pytest

from hannes.campaigns.check import check
from hannes.campaigns.convert import convert
from hannes.campaigns.foreign import plain_table
from hannes.campaigns.foreign.mapping import Column, TextRule
from hannes.campaigns.foreign.text_columns import Delimited
from hannes.campaigns.held_rows import held_rows
from hannes.core.errors import BadInput
from hannes.plants.hand.plant import HandPlant

TIME = np.arange(600) / 500.0
ASKED = np.interp(TIME, [0.0, 0.2, 0.7, 1.1], [0.0, 0.0, 8.0, 0.0])
MOVED = np.round(np.interp(TIME - 0.05, TIME, ASKED, left=0.0) / 1.5e-3) * 1.5e-3
PUSHED = 0.3 * np.tanh(np.gradient(MOVED, TIME)) + 0.05 * MOVED
DRIVE = np.round(PUSHED + 0.01 * np.random.default_rng(1).standard_normal(600), 3)
SOUND = {"t": TIME, "ref": ASKED, "pos": MOVED, "cur": DRIVE}
MAPPING = """[time]
column = "t"
unit = "s"
{time}
[channels.reference]
column = "ref"
unit = "rad"
[channels.position]
column = "pos"
unit = "rad"
{position}
[channels.current]
column = "cur"
unit = "A"
{current}
"""


def converted(folder, time="", position="", current="", **columns):
    np.savez(folder / "log.npz", **{**SOUND, **columns})
    text = MAPPING.format(time=time, position=position, current=current)
    (folder / "map.toml").write_text(text)
    (made,) = convert([folder / "log.npz"], folder / "map.toml")
    return made.recording


def serious(recording):
    return [each for each in check(recording, HandPlant()) if each.level != "note"]


def test_stretches_are_cut_and_are_no_gap(tmp_path):
    made = converted(tmp_path, time='cut = [["0.3 s", "0.4 s"]]')
    assert not ((made.time >= 0.3) & (made.time <= 0.4)).any() and len(made) == 549
    assert serious(made) == []
    with pytest.raises(BadInput, match="pairs"):
        converted(tmp_path, time="cut = [1.0]")


def test_only_readings_of_a_slow_channel_are_kept(tmp_path):
    slow = DRIVE[np.arange(600) // 5 * 5]
    (found,) = serious(converted(tmp_path, cur=slow))
    assert found.mend == ("channels.current.renewed = 5",)
    made = converted(tmp_path, current="renewed = 5", cur=slow)
    assert made.time == pytest.approx(TIME[::5])
    assert made["current"] == pytest.approx(DRIVE[::5])


@pytest.mark.parametrize(
    ("time", "mend"),
    [
        (np.sort(np.r_[TIME[:-1], TIME[30]]), 'time.order = "drop"'),
        (np.r_[TIME[:300], TIME[300:] - 0.1], 'time.sampling = "500 Hz'),
        (TIME[np.r_[:30, 31, 30, 32:600]], 'time.order = "sort"'),
        (np.r_[TIME[:300], TIME[:300]], 'split_at = "restart"'),
        (np.floor(100 * TIME) / 100, 'time.sampling = "'),
    ],
)
def test_a_refusal_says_the_key(tmp_path, time, mend):
    with pytest.raises(BadInput) as error:
        converted(tmp_path, t=time)
    assert error.value.mend[0].startswith(mend) and mend in str(error.value)


def test_a_drive_switched_off_within_a_run(tmp_path):
    off = slice(200, 260)
    position, current = MOVED.copy(), DRIVE.copy()
    position[off], current[off] = position[200], 0.01 * np.resize([1, -1, 0, 1], 60)
    found = serious(converted(tmp_path, pos=position, cur=current))
    assert [each.kind for each in found] == ["disabled"]


def test_a_code_and_a_wrap(tmp_path):
    odd = DRIVE.copy()
    odd[[50, 170, 400, 401]] = -999.0
    (found,) = serious(converted(tmp_path, cur=odd))
    assert found.kind == "missing" and "-999" in found.mend[0]
    (found,) = serious(converted(tmp_path, pos=np.mod(MOVED, 5.0)))
    assert found.kind == "jump" and found.mend[0].startswith("channels.position.unwrap = ")


def test_rows_at_rest_are_not_taken_for_held_frames():
    held = held_rows([MOVED, PUSHED])
    assert not held.any()
    rows = np.arange(600)
    rows[150:156] = 149
    held = held_rows([MOVED[rows], PUSHED[rows]])
    assert held[150:156].all() and held.sum() == 6


@pytest.mark.parametrize("arrow", [True, False])
def test_long_text_is_parsed_as_line_by_line(tmp_path, monkeypatch, arrow):
    monkeypatch.setattr(plain_table, "SHORT", 10)
    if not arrow:
        monkeypatch.setattr(plain_table, "find_spec", lambda name: None)
    file = tmp_path / "log.csv"
    rows = [
        f"{t},{p!r},{c!r}" for t, p, c in zip(TIME, MOVED.tolist(), DRIVE.tolist(), strict=True)
    ]
    file.write_text("\n".join(["t,pos,cur", *rows]) + "\n")
    fast = plain_table.plain_table(file, TextRule(), ())
    slow = Delimited(file, TextRule(), ())
    for name in ("t", "pos", "cur"):
        assert np.array_equal(fast.numbers(Column(name)), slow.numbers(Column(name)))
    for bad in ("1,2", "1,2,x", "1,,3", "1,2,3,4"):
        file.write_text("\n".join(["t,pos,cur", *rows[:300], bad, *rows[300:]]) + "\n")
        assert plain_table.plain_table(file, TextRule(), ()) is None


MEASURED = Path(os.environ.get("HANNES_MEASURED", "nowhere"))


def measured(name):
    if not (MEASURED / name).exists():
        pytest.skip("needs the recordings that HANNES_MEASURED names")
    return MEASURED / name


SO101 = """plant = "hand"
[time]
column = "timestamp"
unit = "us"
from_zero = true
[files.control]
replace = "_state_motor"
by = "_control"
time = {column = "timestamp", unit = "us"}
[channels.reference]
from = "control"
column = "positions"
index = 3
unit = "rad"
[channels.position]
column = "positions"
index = 3
unit = "rad"
[channels.current]
column = "torques"
index = 3
unit = "A"
"""


def test_one_joint_of_the_so101_by_a_mapping(tmp_path):
    (tmp_path / "so101.toml").write_text(SO101)
    files = sorted(measured("so101").glob("*_state_motor.csv.gz"))
    made = convert(files, tmp_path / "so101.toml")
    assert len(made) == len(files) == 12
    for each in made:
        assert 30.0 < 1.0 / np.median(np.diff(each.recording.time)) < 70.0
        assert np.ptp(each.recording["reference"]) >= 0.0
