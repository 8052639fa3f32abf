"""Figures of real machines: their intervals, and the quick judgement where the recordings are."""

import numpy as np
import pytest

from benchmarks import real_machines
from benchmarks.real import black_box, blocks, so101
from hannes.campaigns import third_party
from hannes.core.errors import MissingRecording
from hannes.core.recording.recording import Recording


def test_the_interval_of_a_figure_holds_it_and_shrinks_with_more_blocks():
    rng, widths = np.random.default_rng(3), []
    for count in (20, 320):
        parts = [(rng.normal(0.0, 2.0, 50), np.ones(50)) for _ in range(count)]
        found = blocks.row("rms", blocks.squares(parts), lambda s: float(np.sqrt(s[0] / s[1])))
        assert found["low"] < found["value"] < found["high"]
        widths.append(found["high"] - found["low"])
    assert widths[1] == pytest.approx(widths[0] / 4.0, rel=0.4)


def test_missing_recordings_leave_no_rows(monkeypatch, capsys, tmp_path):
    def missing(name, base_url=None):
        raise MissingRecording(f"the recordings {name} are missing")

    monkeypatch.setattr(third_party, "folder", missing)
    monkeypatch.setenv("HANNES_MEASURED", str(tmp_path))
    assert real_machines.measure(True) == ([], [])
    printed = capsys.readouterr().err
    assert all(f"{name} left out" in printed for name in ("emps", "rh56", "so101"))


def ramp(rng, size=400):
    """A command that walks, and what a lag of 0.1 s makes of it, 40 ms late."""
    time = 0.02 * np.arange(size)
    command = np.repeat(rng.uniform(-0.5, 0.5, size // 20), 20)
    made = black_box.DelayedLag(0.04, 0.1, 0.9, 0.02)
    units = {"time": "s", "reference": "rad", "position": "rad"}
    start = Recording({"time": time, "reference": command, "position": 0.0 * time}, units)
    return start.with_channels({"position": made.position(start)}, {})


def test_the_models_that_know_no_servo_find_a_lag():
    rng = np.random.default_rng(5)
    runs = [ramp(rng) for _ in range(2)]
    lag = black_box.DelayedLag.fitted(runs)
    assert (lag.time, lag.gain, lag.offset) == pytest.approx((0.1, 0.9, 0.02), abs=2e-3)
    assert lag.delay == pytest.approx(0.04, abs=5e-3)
    arx = black_box.ARX.fitted(runs, 8)
    left = [np.std(each.position(runs[0]) - runs[0]["position"]) for each in (lag, arx)]
    assert left[0] < 1e-3 and left[1] < 5e-3


@pytest.mark.slow
def test_the_arm_is_judged_on_some_of_its_recordings(tmp_path, monkeypatch):
    try:
        so101.measured()
    except MissingRecording as error:
        pytest.skip(f"needs recordings: {error}")
    monkeypatch.chdir(tmp_path)
    rows, bounds = real_machines.measure(True, ("so101",))
    assert len(rows) == 7 and len(bounds) == 6
    jaw = [row["holds"] for row in bounds if "Jaw" in row["name"] and "base" not in row["name"]]
    assert all(jaw)
    for name in ("Elbow", "Jaw"):
        page = tmp_path / f"results/benchmarks/real_machines/{name}/round_1/report.html"
        assert page.exists()


@pytest.mark.slow
def test_what_must_be_shown_holds_on_some_of_the_recordings(tmp_path, monkeypatch):
    for name in ("emps", "rh56_finger"):
        try:
            third_party.folder(name)
        except MissingRecording as error:
            pytest.skip(f"needs recordings: {error}")
    monkeypatch.chdir(tmp_path)
    rows, bounds = real_machines.measure(True, ("emps", "rh56"))
    assert {row["machine"][:4] for row in rows} == {"EMPS", "RH56"} and len(bounds) == 9
    assert [row["name"] for row in bounds if not row["holds"]] == []
    assert (tmp_path / "results/benchmarks/real_machines/rh56/report.html").exists()
