"""The benchmark `diagnoses`: its cases, its bounds, and a process that compiles or is stopped."""

import json
import math

import pytest

from benchmarks import diagnoses
from benchmarks.diagnoses import MOST, STOPPED, cases, diagnosed, figures, ratio, warm
from benchmarks.harness import ROOT
from benchmarks.naming_study.apart.kinds import cases as studied
from hannes.core.errors import BadInput


def _row(kind, base, now, verdict="named", effects=("wear",)):
    return {
        "kind": kind,
        "seed": 1,
        "hidden": {"wear.size": 0.5},
        "effects": ["wear"],
        "busy": 1.0,
        "base": {"verdict": "unknown", "effects": [], "seconds": base},
        "now": {"verdict": verdict, "effects": list(effects), "seconds": now},
    }


def test_every_part_has_all_kinds_and_no_case_of_the_study():
    asked = cases(False)
    assert len(asked) == len(set(asked)) == 25
    assert {name for name, _ in asked[:5]} == {name for name, _ in cases(True)}
    known = [*studied("development"), *studied("quoted")]
    assert not {seed for _, seed in asked} & {seed for _, seed in known}


def test_bounds_of_each_kind_of_all_and_of_the_longest():
    poor = [_row("single, poor", 100.0, now) for now in (10.0, 40.0, 130.0)]
    done = [*poor, _row("single, naive", 100.0, 20.0, "unknown", ())]
    kinds, each, bounds = figures(done)
    assert [kind["now_right"] for kind in kinds] == [3, 0] and len(each) == 4
    assert [row["value"] for row in bounds] == pytest.approx([0.4, 0.3, 130.0])
    assert [row["holds"] for row in bounds] == [True, True, False]
    assert figures([]) == ([], [], [])


def test_who_is_stopped_has_taken_longer_than_the_row_says():
    row = _row("single, poor", MOST, 60.0)
    row["base"]["verdict"] = STOPPED
    assert ratio(row) == 60.0 / MOST
    assert ratio(row | {"now": row["base"]}) == math.inf


def test_who_failed_quickly_was_not_fast():
    rows = [_row("single, poor", 100.0, 1.0, "failed"), _row("single, poor", 100.0, 10.0)]
    assert ratio(rows[0]) == math.inf
    assert [row["holds"] for row in figures(rows[:1])[2]] == [False, False, False]
    kinds, _, _ = figures(rows)
    assert kinds[0]["now_failed"] == 1


def test_a_case_that_the_base_failed_is_left_out_and_counted():
    left = _row("single, poor", 1.0, 10.0)
    left["base"]["verdict"] = "failed"
    rows = [left, _row("single, poor", 100.0, 10.0)]
    _, _, (poor, _, _) = figures(rows)
    assert poor["value"] == 0.1 and "median of 1 (1 left out: base failed)" in poor["name"]
    _, _, (poor, _, longest) = figures(rows[:1])
    assert not poor["holds"] and longest["holds"]


@pytest.mark.parametrize("word, codes", [("--show", "ab"), ("--resume", "a")])
def test_rows_of_another_code_are_not_mixed(word, codes, tmp_path, monkeypatch):
    file = tmp_path / "rows.jsonl"
    rows = [_row("single, poor", 100.0, 10.0) | {"code": code} for code in codes]
    file.write_text("".join(json.dumps(row) + "\n" for row in rows))
    monkeypatch.setattr("sys.argv", ["diagnoses", word, "--cases", str(file)])
    monkeypatch.setenv("HANNES_BASE", str(tmp_path))
    with pytest.raises(BadInput, match="cases of codes"):
        diagnoses.main()
    assert len(file.read_text().splitlines()) == len(rows)


def test_a_base_may_be_named_from_here(tmp_path, monkeypatch):
    asked = []

    def run(file, cases, ask, resume, workers):
        asked.append(ask.args[0])
        return []

    monkeypatch.setattr(diagnoses.study, "run", run)
    monkeypatch.setattr("sys.argv", ["diagnoses", "--cases", str(tmp_path / "rows.jsonl")])
    monkeypatch.setenv("HANNES_BASE", "base")
    monkeypatch.chdir(tmp_path)
    diagnoses.main()
    assert asked == [tmp_path.resolve() / "base"]


def test_what_compiled_is_run_again(tmp_path, monkeypatch):
    took = iter([30.0, 20.0, 21.0])

    def asked(root, campaign, cache):
        seconds = next(took)
        if seconds == 30.0:
            (cache / "machine-code" / "hand").mkdir(parents=True)
        return {"seconds": seconds}

    monkeypatch.setattr(diagnoses, "diagnosed", asked)
    assert [warm(ROOT, tmp_path, tmp_path)["seconds"] for _ in range(2)] == [20.0, 21.0]


def test_a_campaign_that_cannot_be_read_has_failed(tmp_path):
    said = diagnosed(ROOT, tmp_path / "none.toml", tmp_path)
    assert said["verdict"] == "failed" and "none.toml" in said["reason"]
    assert 0.0 < said["seconds"] < 60.0
