"""The last line of check, convert and calibrate: what to type next; the stages in a pipe."""

import json
from dataclasses import replace

import clean
import oven
import pytest

from hannes.commands.calibrate import calibrate
from hannes.commands.cli import main
from hannes.commands.next_step import after_calibrate

MAPPING = """\
plant = "hand"
[time]
column = "t"
unit = "s"
[channels.current]
column = "i"
unit = "A"
[channels.reference]
column = "r"
unit = "rad"
[channels.position]
column = "p"
unit = "rad"
"""


def last_line(capsys):
    return capsys.readouterr().out.splitlines()[-1]


def test_check_leads_to_a_campaign_or_to_the_fault(tmp_path, capsys):
    recording = clean.shipped("dynamometer")
    good, bad = str(tmp_path / "good.h5"), str(tmp_path / "bad.h5")
    recording.write(good)
    recording.with_channels({"position": 57.3 * recording["position"]}, {}).write(bad)
    assert main(["check", good]) == 0
    line = last_line(capsys)
    assert line.startswith(f'next: write [[recording]] with file = "{good}" into campaign.toml')
    assert main(["check", good, bad]) == 2
    line = last_line(capsys)
    assert f"mend {bad} as" in line and line.endswith(f"then: hannes check {good} {bad}")
    campaign = tmp_path / "campaign.toml"
    campaign.write_text('[[recording]]\nfile = "good.h5"\n', encoding="utf-8")
    assert main(["check", str(campaign)]) == 0
    assert f"hannes diagnose {campaign}" in last_line(capsys)
    assert main(["check", str(campaign), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recordings"]


def test_convert_leads_to_check_or_to_the_mapping(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.toml").write_text(MAPPING, encoding="utf-8")
    run = clean.shipped("dynamometer")
    for name, factor in (("right", 1.0), ("degrees", 57.29578)):
        columns = run.time, run["current"], run["reference"], factor * run["position"]
        rows = [",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True)]
        (tmp_path / f"{name}.log").write_text("\n".join(["t,i,r,p", *rows]), encoding="utf-8")
    words = ["--mapping", "map.toml", "--out"]
    assert main(["convert", "right.log", *words, "right.csv"]) == 0
    assert last_line(capsys).endswith("then: hannes check campaign.toml")
    assert main(["convert", "degrees.log", *words, "degrees.csv"]) == 0
    line = last_line(capsys)
    assert line == "next: change map.toml as the fault in degrees.csv says, then convert again"
    assert main(["convert", "right.log", *words, "right.csv", "--json"]) == 0
    assert "next:" not in capsys.readouterr().out


@pytest.fixture(scope="module")
def fitted():
    """An oven whose gain and time are found."""
    asked = {"parameters": ["oven.gain", "oven.time"]}
    return calibrate(oven.campaign(1, {"oven.gain": 2.1}, **asked), progress=False)


def test_calibrate_leads_on_by_the_worst_thing(fitted):
    def line(result):
        return after_calibrate("oven.toml", "out", result)

    assert line(fitted).startswith("next: hannes diagnose oven.toml")
    assert line(fitted).endswith("hannes hand out/hand.toml")
    first, second = fitted.answers
    unknown = replace(first, label="not identified")
    bound = replace(second, label="at its bound")
    confounded = replace(first, label="confounded", partners=("oven.time",))
    assert '"oven.gain" out of' in line(replace(fitted, answers=(unknown, second)))
    assert 'widen "oven.time"' in line(replace(fitted, answers=(unknown, bound)))
    assert line(replace(fitted, answers=(confounded, bound))).startswith('next: leave "oven.gain"')
    wrong = replace(fitted.repeatable_residual, repeats=True)
    assert line(replace(fitted, repeatable_residual=wrong)) == "next: hannes diagnose oven.toml"
    stopped = replace(fitted, found=replace(fitted.found, interrupted=True))
    assert line(stopped) == "next: hannes calibrate oven.toml"


def test_the_sentence_says_the_worst_thing_first(fitted):
    first, second = fitted.answers
    assert fitted.sentence == "2 of 2 parameters identified."
    confounded = replace(first, label="confounded", partners=("oven.time",))
    one = replace(fitted, answers=(confounded, second))
    assert one.sentence == "Confounded: oven.gain; 1 of 2 parameters identified."
    wrong = replace(one, repeatable_residual=replace(fitted.repeatable_residual, repeats=True))
    assert wrong.sentence.startswith("The model does not fit these recordings; confounded: oven")
    stopped = replace(wrong, found=replace(fitted.found, interrupted=True))
    assert stopped.sentence.startswith("Interrupted, best so far: the model does not fit")


def test_calibrate_says_each_stage_once_in_a_pipe(capsys):
    asked = {"parameters": ["oven.gain"]}
    campaign = oven.campaign(1, {"oven.gain": 2.1}, runs=4, **asked)
    calibrate(campaign, progress=True)
    printed = capsys.readouterr()
    lines = [each.partition(": ")[2].partition(",")[0] for each in printed.err.splitlines()]
    assert lines[0] == "round 1" and {"intervals", "effects that may be missing"} <= {*lines}
    assert len(lines) == len(set(lines))
    assert printed.out == "" and "\r" not in printed.err
    for quiet in (None, False):
        calibrate(campaign, progress=quiet)
        assert capsys.readouterr().err == ""
