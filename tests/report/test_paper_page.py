"""The page: whole without a network, honest about what is missing, the same bytes each time."""

import json
import re

import numpy as np
import pytest

from hannes.commands.cli import main
from hannes.commands.reproduce import reproduce as with_diagnoses
from hannes.core.errors import BadInput
from hannes.report.paper.page import reproduce

RIGID = ("Hand dynamometer", "Aluminium block", "Ultem block", "Crutch handle")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Results folder, what `reproduce` returned, and the page's text."""
    out = tmp_path_factory.mktemp("page") / "reproduce"
    content = reproduce(out, progress=False, quick=True)
    return out, content, (out / "index.html").read_text(encoding="utf-8")


def test_every_figure_that_must_hold_holds(page):
    _, content, _ = page
    assert len(content["must_show"]) >= 15
    assert [row["name"] for row in content["must_show"] if not row["holds"]] == []
    assert all({"name", "value", "bound", "holds"} <= set(row) for row in content["must_show"])


def test_the_page_loads_nothing_from_elsewhere(page):
    _, _, text = page
    assert "<script" not in text
    assert re.findall(r'(?:src|srcset|@import|url\()\s*=?\s*["\']?https?:', text) == []
    assert re.findall(r'<link[^>]+href="http', text) == []


def test_the_page_separates_fit_from_validation_and_virtual_from_real(page):
    _, _, text = page
    assert "not a validation" in text and "virtual" in text
    assert "Missing here" in text  # no diagnosis was given


def test_figures_are_named_and_described(page):
    _, _, text = page
    figures = re.findall(r"<figure.*?</figure>", text, flags=re.DOTALL)
    assert len(figures) >= 7
    assert all('aria-label="' in each and "<figcaption>" in each for each in figures)


def test_same_run_same_bytes(page, tmp_path):
    _, _, text = page
    reproduce(tmp_path / "again", progress=False, quick=True)
    assert (tmp_path / "again" / "index.html").read_text(encoding="utf-8") == text


def evaluation(worst):
    """What `hannes evaluate` writes, of two objects."""
    share = {"f1_windows": 0.96, "f1_grasps": 1.0, "stable_in_time": 0.9}
    names = ("Sponge", "Hand dynamometer")
    objects = [{"name": n, "class": "soft", **share, "stiffness_N_per_m": 900.0} for n in names]
    made = {"objects": objects, **share, "f1_worst": worst}
    made["learning_curve"] = [{"grasps": 500, "f1_worst": 0.7, **share}]
    made["confusion"] = {"soft": {"soft": 3, "rigid": 0, "don't know": 1}}
    made |= {
        "reliability": {"calibration_error": 0.021},
        "stable_after_s": {"soft": 0.05, "rigid": None},
    }
    made["force"] = {"grasps": 4, "answered": 3, "median_error_percent": 5.0}
    made["force"] |= {"interval_holds": 0.75, "interval_width": 1.5}
    made["stiffness"] = {"grasps": 4, "answered": 0}
    return made


def test_table_3_has_means_by_class_as_the_paper_forms_them():
    """The published ones follow from the published objects with the sample standard deviation."""
    from hannes.report.paper import published, table_3

    for label, (mean, spread) in published.TABLE_3_BY_CLASS.items():
        found = [
            each
            for name, each in published.TABLE_3.items()
            if (name in RIGID) == (label == "rigid")
        ]
        assert np.mean(found) == pytest.approx(mean, abs=0.051)
        assert np.std(found, ddof=1) == pytest.approx(spread, abs=0.051)
    made = evaluation(0.9)
    made["objects"][0]["f1_windows"] = 0.9
    (table, *_) = table_3.found(made).tables
    rows = {row[0]: row for row in table.rows}
    assert rows["Soft objects, mean ± SD"][2:5] == ("89.5 ± 12.5", "93.0 ± 4.2", "100.0 ± 0.0")
    assert rows["Rigid objects, mean ± SD"][2:5] == ("93.5 ± 3.4", "–", "–")


def test_missing_recordings_are_named_on_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("HANNES_MEASURED", str(tmp_path / "nowhere"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "evaluation.json").write_text(json.dumps(evaluation(0.9)))
    more = ["--recognition", str(tmp_path), "--coming", "slack", "--json"]
    assert main(["reproduce", "--out", str(tmp_path / "out"), *more]) == 0
    content = json.loads(capsys.readouterr().out)
    assert all(row["holds"] for row in content["must_show"])
    assert sum("ten virtual objects" in row["name"] for row in content["must_show"]) == 3
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "DATA_EMPS.mat" in text and "HANNES_MEASURED" in text
    assert "Table III: rigid or soft" in text and "Predictions by window" in text
    assert text.count("Still coming:") == 1 and "not diagnosed in this run" not in text


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"coming": ["slak"]}, 'no part "slak" can come; did you mean "slack"'),
        ({"coming": ["slack"], "slack": "results"}, "slack is given, so it is not coming"),
    ],
)
def test_parts_that_cannot_come_are_refused(tmp_path, asked, said):
    with pytest.raises(BadInput, match=said):
        with_diagnoses(tmp_path / "out", **asked)


def test_table_3_stands_beside_the_papers(tmp_path):
    from hannes.report.paper import table_3

    made = evaluation(0.8)
    (tmp_path / "evaluation.json").write_text(json.dumps(made))
    read = table_3.read(tmp_path)
    assert [row["holds"] for row in table_3.checks(read)] == [True, True, False]
    table, confusion, estimates, learning = table_3.found(read).tables
    assert confusion.rows == (("soft", "4", "75.0", "0.0", "25.0"),)
    assert (
        "2.1 points" in confusion.note
        and "soft objects 50 ms after contact, rigid ones never" in confusion.note
    )
    assert estimates.rows == (("Peak grip force", "3 of 4", "5.0", "75.0", "1.5"),)
    assert learning.rows == (("500", "96.0", "100.0", "70.0", "90.0"),)
    assert table.rows[0][:4] == ("Sponge", "soft", "99.0", "96.0")
    assert table.rows[-1][:4] == ("Average", "", "91.1", "96.0")
    (tmp_path / "evaluation.json").write_text("{}")
    with pytest.raises(BadInput, match="not written by this version's"):
        table_3.read(tmp_path)
