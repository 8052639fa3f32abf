"""Figures of real machines: their intervals, and the quick judgement where the recordings are."""

import numpy as np
import pytest

from benchmarks import real_machines
from benchmarks.real import blocks
from hannes.campaigns import third_party
from hannes.core.errors import MissingRecording


def test_the_interval_of_a_figure_holds_it_and_shrinks_with_more_blocks():
    rng, widths = np.random.default_rng(3), []
    for count in (20, 320):
        parts = [(rng.normal(0.0, 2.0, 50), np.ones(50)) for _ in range(count)]
        found = blocks.row("rms", blocks.squares(parts), lambda s: float(np.sqrt(s[0] / s[1])))
        assert found["low"] < found["value"] < found["high"]
        widths.append(found["high"] - found["low"])
    assert widths[1] == pytest.approx(widths[0] / 4.0, rel=0.4)


def test_missing_recordings_leave_no_rows(monkeypatch, capsys):
    def missing(name, base_url=None):
        raise MissingRecording(f"the recordings {name} are missing")

    monkeypatch.setattr(third_party, "folder", missing)
    assert real_machines.measure(True) == ([], [])
    printed = capsys.readouterr().err
    assert "emps left out" in printed and "rh56 left out" in printed


@pytest.mark.slow
def test_what_must_be_shown_holds_on_some_of_the_recordings(tmp_path, monkeypatch):
    for name in ("emps", "rh56_finger"):
        try:
            third_party.folder(name)
        except MissingRecording as error:
            pytest.skip(f"needs recordings: {error}")
    monkeypatch.chdir(tmp_path)
    rows, bounds = real_machines.measure(True)
    assert {row["machine"][:4] for row in rows} == {"EMPS", "RH56"} and len(bounds) == 9
    assert [row["name"] for row in bounds if not row["holds"]] == []
    assert (tmp_path / "results/benchmarks/real_machines/rh56/report.html").exists()
