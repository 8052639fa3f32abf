"""The benchmark of faults in logs: its kinds, its strengths, one case from fault to mended file."""

import numpy as np
import pytest

from benchmarks.intake.__main__ import main
from benchmarks.intake.bases import Logger, base, logged
from benchmarks.intake.case import case, strength_of
from benchmarks.intake.consequence import consequence
from benchmarks.intake.log import Log, all_kinds
from benchmarks.intake.mapped import mended, toml
from benchmarks.intake.summary import figures
from benchmarks.truth import servo


def test_kinds_are_many_and_leave_the_sound_log_alone():
    assert len(all_kinds()) >= 35
    time = np.arange(400) / 200.0
    columns = {"time": time, "reference": np.sin(time), "position": np.sin(time - 0.05),
               "current": np.cos(time), "duty": 0.1 * np.cos(time)}  # fmt: skip
    log = Log("servo", columns, columns)
    for kind in all_kinds().values():
        kind.inject(log, 0.5, np.random.default_rng(1))
        assert np.array_equal(log.columns["position"], np.sin(time - 0.05)), kind.name


def test_a_mapping_is_changed_as_findings_say():
    mapping = {"plant": "hand", "time": {"column": "t", "unit": "s"},
               "channels": {"position": {"column": "p", "unit": "rad"}}}  # fmt: skip
    changed = mended(mapping, ['time.cut = [["0 s", "1 s"]]', 'channels.position.unit = "deg"'])
    assert 'unit = "deg"' in toml(changed) and 'cut = [["0 s", "1 s"]]' in toml(changed)
    assert mended(mapping, ["leave out the file"]) is None
    assert mapping["channels"]["position"]["unit"] == "rad"


@pytest.mark.parametrize("name", ["counter that wraps", "swapped rows"])
def test_one_case_is_found_named_and_mended(name):
    row = case(name, "gross", 3)
    assert row["strength"] == "gross" and row["found"] and row["named"] and row["mended"]
    rows, bounds = figures([{"kind": f"{name} / gross", "seed": 3, "fault": name, **row}])
    assert rows[0]["kind"] == name and all(each["holds"] for each in bounds)


def test_the_small_form_of_the_study(tmp_path, capsys):
    kinds = ["--kinds", "swapped rows", "degrees as radians"]
    assert main(["--quick", "--cases", str(tmp_path / "cases.jsonl"), *kinds]) == 0
    assert "gross faults found, of 2" in capsys.readouterr().out
    assert main(["--so-far", "--quick", "--cases", str(tmp_path / "cases.jsonl")]) == 0


def test_a_servo_under_its_own_command_has_no_consequence():
    run = base("servo", 1)
    log = logged(run, Logger(), True, np.random.default_rng(1))
    assert consequence(run, log) < 0.2
    late = log.rows(slice(600, None))  # command and motion together
    assert consequence(run, late.changed(time=late.time - late.time[0])) < 0.3
    apart = log.changed(position=log.columns["position"] + 0.2)
    assert consequence(run, apart) > 1.0


def test_strengths():
    assert [strength_of(x) for x in (2.0, 0.5, 0.1)] == ["gross", "middling", "small"]


def test_the_servo_follows_and_stands_where_its_drive_is_off():
    asked = 0.5 * np.sin(np.arange(2000) / 300.0)
    run = servo.simulate(servo.SERVO, asked)
    assert np.abs(run["position"] - asked).max() < 0.1
    off = servo.simulate(servo.SERVO, asked, np.r_[np.ones(1000), np.zeros(1000)])
    assert (off["drive"][1000:] == 0.0).all()
