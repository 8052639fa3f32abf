"""A dynamometer's force merged by onset: against the force that a simulated grasp has."""

import json
import sys
import types

import numpy as np
import pytest

from hannes import Hand, Recording, load_experiment, observe, simulate
from hannes.bench import dynamometer_live
from hannes.bench.dynamometer import ForceLog, merged, read_vernier
from hannes.commands.cli import main
from hannes.commands.cli_bench import _with_force
from hannes.core.errors import BadInput

LATE = 3.217  # s that the dynamometer's clock is off


@pytest.fixture(scope="module", params=["dynamometer", "soft-ball"])
def grasp(request):
    (variant,) = load_experiment(request.param)
    return observe(variant.hand, simulate(Hand(), variant.experiment).require())


@pytest.fixture(scope="module")
def bare(grasp):
    names = ("time", "reference", "position", "current")
    return Recording({name: grasp[name] for name in names}, {n: grasp.units[n] for n in names})


def export(grasp, path, rest=0.0, header='"Latest: Time (s)","Latest: Force (N)"', sep=","):
    """The CSV of a dynamometer at 100 Hz that was started a second before, and read on after."""
    time = np.arange(-1.0, grasp.time[-1] + 0.5, 0.01)
    force = np.interp(time, grasp.time, grasp["force"]) + rest
    rows = [f"{t + LATE:.3f}{sep}{f:.3f}" for t, f in zip(time, force, strict=True)]
    text = "\n".join([header, *rows]) + "\n"
    path.write_text(text.replace(".", ",") if sep == ";" else text)
    return path


@pytest.mark.parametrize("how", [
    {}, {"rest": -3.4}, {"header": "Data Set 1:Time(s);Data Set 1:Force(N)", "sep": ";"},
], ids=["plain", "not zeroed", "decimal comma"])  # fmt: skip
def test_the_force_is_where_it_was(grasp, bare, tmp_path, how):
    made = merged(bare, read_vernier(export(grasp, tmp_path / "run.csv", **how)))
    shift = json.loads(made.conversion)["dynamometer"]["shift_s"]
    assert shift == pytest.approx(-LATE, abs=0.015)
    assert made["force"].max() == pytest.approx(grasp["force"].max(), rel=0.01)
    assert made.units["force"] == "N" and np.array_equal(made["current"], bare["current"])


def test_a_merge_by_the_command_says_its_shift(grasp, bare, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("hannes.bench.record.recover", lambda raw, progress: bare)
    raw, out = tmp_path / "grasp.h5.rawlog", tmp_path / "out.h5"
    raw.write_bytes(b"")
    run = export(grasp, tmp_path / "run.csv")
    asked = ["record", "--recover", str(raw), "--dynamometer", str(run), "--out", str(out)]
    assert main(asked) == 0
    shift = json.loads(Recording.read(out).conversion)["dynamometer"]["shift_s"]
    assert f"is merged, its clock shifted by {shift:+.3f} s" in capsys.readouterr().err


@pytest.mark.parametrize(("text", "words"), [
    ("Time (s),Force (lb)\n0,1\n", "Force (N)"),
    ("a,b\n1,2\n", "Force (N)"),
    ("Time (s),Force (N)\n0,1\n", "1 samples"),
    ("Time (s),Force (N)\n" + "1,1\n" * 20, "does not rise"),
    ("Time (s),Force (N)\n" + "x,1\n" * 20, "expected numbers"),
    ("Time (s),Force (N)\n" + "nan,1\n" * 20, "not finite"),
])  # fmt: skip
def test_what_is_no_export_is_refused_in_one_line(tmp_path, text, words):
    (tmp_path / "x.csv").write_text(text)
    with pytest.raises(BadInput) as refused:
        read_vernier(tmp_path / "x.csv")
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_a_run_without_contact_or_cut_off_is_refused(grasp, bare, tmp_path):
    path = export(grasp, tmp_path / "run.csv")
    lines = path.read_text().splitlines()
    path.write_text(
        "\n".join(line if k == 0 else line.split(",")[0] + ",0" for k, line in enumerate(lines))
    )
    with pytest.raises(BadInput, match="no onset"):
        merged(bare, read_vernier(path))
    path.write_text("\n".join(lines[:160]))
    with pytest.raises(BadInput, match="ends in the grasp"):
        merged(bare, read_vernier(path))


class FakeDevice:
    """Gives a ramp, as Vernier's library does: an array of values a read."""

    def __init__(self):
        self.values, self.left = [], 40

    def open(self, auto_start):
        return True

    def read(self, timeout):
        if not self.left:
            dynamometer_live.time.sleep(0.01)
            return False
        self.left -= 1
        self.values.append(float(40 - self.left))
        return True

    def get_enabled_sensors(self):
        return [self]

    def clear(self):
        self.values = []

    def __getattr__(self, name):
        return lambda *_, **__: None


def test_a_live_device_is_read_by_the_vendors_library(monkeypatch):
    device = FakeDevice()
    library = types.SimpleNamespace(get_device=lambda: device, quit=lambda: None)
    module = types.SimpleNamespace(GoDirect=lambda use_ble, use_usb: library)
    monkeypatch.setitem(sys.modules, "godirect", module)
    with dynamometer_live.LiveDynamometer() as live:
        while device.left:
            dynamometer_live.time.sleep(0.01)
    log = live.log()
    assert log.force.tolist() == list(range(1, 41))
    assert np.diff(log.time) == pytest.approx(0.01)


def test_without_the_library_one_line_says_what_it_is(monkeypatch):
    monkeypatch.setitem(sys.modules, "godirect", None)
    with pytest.raises(BadInput, match="GPL"):
        dynamometer_live.LiveDynamometer()


def test_force_that_fits_no_recording_is_kept(bare, tmp_path):
    flat = ForceLog(np.arange(0.0, 2.0, 0.01), np.full(200, 0.5))
    live = types.SimpleNamespace(log=lambda: flat)
    raw = tmp_path / "grasp.h5.rawlog"
    made, why = _with_force(bare, live, raw, tmp_path / "grasp.h5")
    assert made is bare and "no onset" in why and f"--dynamometer {raw}.force.csv" in why
    kept = read_vernier(f"{raw}.force.csv")
    assert kept.time == pytest.approx(flat.time) and kept.force == pytest.approx(flat.force)


def test_a_dynamometer_without_a_sample_leaves_the_recording(bare, tmp_path):
    def nothing():
        raise BadInput("no sample came from the dynamometer")

    live = types.SimpleNamespace(log=nothing)
    made, why = _with_force(bare, live, tmp_path / "x.rawlog", tmp_path / "x.h5")
    assert made is bare and "no sample came" in why
