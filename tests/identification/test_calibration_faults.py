"""What `hannes calibrate` refuses in one line, before any fit, and what can be accepted."""

import json
from dataclasses import replace

import clean
import numpy as np
import oven
import pytest

from hannes.campaigns.campaign import Entry
from hannes.commands.calibrate import calibrate
from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.identification.binned_run import View
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.plants.axis.plant import Axis

ASKED = 'parameters = ["motor.dry_friction"]'


def channel(name, change):
    """A spoiler that changes one channel."""
    return lambda run: run.with_channels({name: change(run[name].copy())}, {})


def kept(keep):
    """A spoiler that keeps some samples, under their own times."""
    return lambda run: run.with_channels({n: run[n][keep(run)] for n in run.channels}, {})


def counted(run):
    """Samples lost under a clock that runs on."""
    rows = np.delete(np.arange(len(run)), np.arange(180, 240))
    lost = {name: run[name][rows] for name in run.channels}
    return run.with_channels({**lost, "time": run.time[: rows.size]}, {})


def set_at(values, place, change):
    values[place] = change(values[place])
    return values


def drifting(time):
    return time * (1.0 + 0.025 * (np.arange(time.size) / time.size - 1.0))


SPOILT = {
    "saturated current": (channel("current", lambda x: np.minimum(x, 0.6 * x.max())), "clips"),
    "dropped samples": (
        kept(lambda run: np.delete(np.arange(len(run)), np.arange(400, 440))),
        "40 samples lost",
    ),
    "dropped unseen": (counted, "samples lost at"),
    "clock drift": (channel("time", drifting), "drifts"),
    "encoder jump": (
        channel("position", lambda x: set_at(x, slice(500, None), lambda y: y + 2.0)),
        "lost count",
    ),
    "dead channel": (channel("current", lambda x: np.full(x.size, 0.37)), "stays at"),
    "frozen sensor": (
        channel("current", lambda x: set_at(x, slice(300, 500), lambda y: y[0])),
        "exactly",
    ),
    "degrees": (channel("position", np.degrees), "degrees"),
    "motor side": (channel("position", lambda x: 19.0 * x), "the motor's side"),
    "milliamperes": (channel("current", lambda x: 1e3 * x), "thousandths"),
    "percent": (channel("duty", lambda x: 100.0 * x), "percent"),
    "milliseconds": (channel("time", lambda x: 1e3 * x), "milliseconds taken"),
    "reversed position": (channel("position", lambda x: -x), "reversed"),
    "reversed current": (channel("current", lambda x: -x), "reversed"),
    "late start": (kept(lambda run: run.time > 0.4), "begins after"),
    "two clocks": (
        channel("reference", lambda x: np.concatenate([np.full(200, x[0]), x[:-200]])),
        "before reference",
    ),
}


def closures(count=3):
    """Free closures of one hand, each with noise of its own."""
    run, rng = clean.shipped("full-closure"), np.random.default_rng(1)
    noise = [0.01 * rng.standard_normal(len(run)) for _ in range(count)]
    return [run.with_channels({"current": run["current"] + each}, {}) for each in noise]


def campaign(folder, runs, asked=ASKED, plant="hand"):
    """Write recordings and their campaign; return the words of the command."""
    for number, run in enumerate(runs):
        run.write(folder / f"run{number}.csv")
    rows = '[[recording]]\nfile = "run*.csv"\ncondition = "void"\nrole = "fit"\n'
    text = f'plant = "{plant}"\n{rows}[calibrate]\n{asked}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return ["calibrate", str(folder / "campaign.toml"), "--trust", "--out", str(folder / "out")]


def refused(capsys, words, status=2):
    """The line that is said."""
    assert main(words) == status
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = printed.err.splitlines()
    (line,) = [each for each in lines if "compiling" not in each and "calibrating, " not in each]
    return line


@pytest.mark.parametrize("fault", SPOILT)
def test_every_fault_of_a_recording_is_one_line_before_any_fit(tmp_path, capsys, fault):
    spoil, said = SPOILT[fault]
    first, second, third = closures()
    line = refused(capsys, campaign(tmp_path, [first, second, spoil(third)]))
    assert line.startswith("hannes: run2.csv: ") and said in line and "accept = [" in line
    assert not (tmp_path / "out").exists()


def test_honest_recordings_are_not_refused(tmp_path, monkeypatch):
    class Reached(BaseException):  # which no guard takes for a failure
        pass

    def run(_):
        raise Reached

    monkeypatch.setattr("hannes.identification.calibration.search.Search.run", run)
    with pytest.raises(Reached):
        main(campaign(tmp_path, closures()))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("position_rad", "position_mm", "comes in mm, expected rad"),
        ("current_A", "current_V", "comes in V, expected A"),
        ("current_A", "curent_A", 'channel "curent" is unknown to the plant hand'),
    ],
)
def test_units_that_contradict_the_plant_are_one_line(tmp_path, capsys, old, new, said):
    words = campaign(tmp_path, closures())
    file = tmp_path / "run1.csv"
    file.write_text(file.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    line = refused(capsys, words)
    assert said in line and "run1.csv" in line


def test_more_parameters_than_the_recordings_bear_are_one_line(tmp_path, capsys):
    asked = 'parameters = ["motor.resistance", "motor.torque_constant", "motor.dry_friction", '
    asked += '"mcp.coulomb_friction", "pip.coulomb_friction"]'
    line = refused(capsys, campaign(tmp_path, closures(1), asked))
    assert "5 parameters are more than 1 recordings" in line and "record more runs" in line


def test_what_can_be_accepted_is_fitted_and_reported(tmp_path, capsys):
    spoilt = oven.campaign(1, {"oven.gain": 2.5}, runs=4, parameters=["oven.gain"])
    runs = [each.recording for each in spoilt.entries]
    rows = np.delete(np.arange(len(runs[3])), np.arange(60, 90))
    runs[3] = runs[3].with_channels({n: runs[3][n][rows] for n in runs[3].channels}, {})
    words = campaign(tmp_path, runs, 'parameters = ["oven.gain"]', "oven:Oven")
    assert 'accept = ["gap"]' in refused(capsys, words)
    words = campaign(tmp_path, runs, 'parameters = ["oven.gain"]\naccept = ["gap"]', "oven:Oven")
    assert main(words) == 0
    assert "30 samples lost" in capsys.readouterr().out
    (issue,) = json.loads((tmp_path / "out" / "calibration.json").read_text("utf-8"))["findings"]
    assert issue["file"] == "run3.csv" and issue["kind"] == "gap"
    assert "30 samples lost" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_a_kind_that_no_check_knows_cannot_be_accepted():
    with pytest.raises(BadInput, match='did you mean "gap"'):
        calibrate(oven.campaign(1, {}, parameters=["oven.gain"], accept=["gaps"]), progress=False)


def test_a_fit_that_does_not_settle_says_what_to_try(tmp_path, capsys, monkeypatch):
    few = replace(CALIBRATION, max_evaluations=2, max_rounds=2)
    monkeypatch.setattr("hannes.identification.calibration.least_squares.CALIBRATION", few)
    monkeypatch.setattr("hannes.identification.calibration.search.CALIBRATION", few)
    far = {"oven.gain": 9.0, "oven.time": 3.0, "oven.offset": 4.0}
    runs = [each.recording for each in oven.campaign(2, far).entries]
    asked = 'parameters = ["oven.gain", "oven.time", "oven.offset"]'
    line = refused(capsys, campaign(tmp_path, runs, asked, "oven:Oven"), status=3)
    assert "did not converge" in line and "try fewer parameters" in line
    assert not (tmp_path / "out").exists()


def test_a_machine_that_cannot_run_as_given_says_what_to_try(tmp_path, capsys):
    runs = [each.recording for each in oven.campaign(3, {}).entries]
    words = campaign(tmp_path, runs, 'parameters = ["oven.gain"]', "oven:Oven")
    toml = tmp_path / "campaign.toml"
    (tmp_path / "hot.toml").write_text('base = "oven:Oven"\n[parameters]\n"oven.time" = "0.06 s"\n')
    toml.write_text('base = "hot.toml"\n' + toml.read_text(encoding="utf-8"), encoding="utf-8")
    line = refused(capsys, words, status=3)
    assert "flames" in line and "try" in line


def test_a_recording_of_which_no_sample_counts_is_refused():
    """Of the axis neither the first 0.1 s nor the last 0.05 s do."""
    with pytest.raises(BadInput, match=r"short: .* got none in 0\.12 s"):
        View(Entry("short", clean.swing().between(1.0, 1.12), "", "fit"), Axis(), ("drive",), ())
