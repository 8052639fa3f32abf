"""Calibration of the hand and of the real axis, from campaign to page."""

import json
import signal
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from hannes.campaigns import third_party
from hannes.campaigns.campaign import Entry
from hannes.campaigns.campaign_file import read_campaign
from hannes.commands.calibrate import calibrate
from hannes.commands.cli import main
from hannes.core.errors import MissingRecording
from hannes.core.recording.recording import Recording
from hannes.identification.binned_run import BIN, View
from hannes.identification.calibration.simulator import Model
from hannes.identification.calibration.tuning import CALIBRATION
from hannes.plants.hand import batch_runs
from hannes.plants.hand import plant as hand_plant
from hannes.plants.hand.recorded_experiment import experiment_of
from hannes.simulation.experiment import shipped as library
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import load_hand
from hannes.simulation.virtual_recordings import virtual_recordings


def test_virtual_recordings_do_not_name_what_made_them():
    made = virtual_recordings(shipped_runs("dynamometer-runs"))
    assert len(made) == 8
    for recording in made.values():
        assert recording.hand == "" and "object.stiffness" not in recording.experiment
        assert "30000" not in recording.experiment
    first, second = list(made.values())[:2]
    assert not (first["current"] == second["current"]).all()


def shipped_runs(name):
    return library.folder() / "virtual" / f"{name}.toml"


@pytest.mark.slow
def test_contact_from_the_motor_current_finds_the_dynamometer(tmp_path, capsys):
    out = tmp_path / "contact"
    assert main(["calibrate", "dynamometer-contact", "--out", str(out), "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    assert written == json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    stiffness, damping, friction = (
        written["parameters"][f"object.{name}"] for name in ("stiffness", "damping", "friction")
    )
    assert stiffness["value"] == pytest.approx(30000.0, rel=0.05)
    assert stiffness["low"] < 30000.0 < stiffness["high"]
    assert friction["value"] == pytest.approx(0.45, rel=0.05)
    assert damping["label"] == "not identified"
    assert written["remains"]["repeats"] is None  # as few runs may all be off alike by chance
    assert all(start["agrees"] for start in written["starts"])
    gap = written["gap"]["current"]
    assert gap["after"] < 1.3 * gap["floor"] < gap["as_given"]
    hand = load_hand(out / "hand.toml")
    assert hand.parameters["object.stiffness"] == stiffness["value"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "not identified" in page and "<script" not in page
    as_found, shipped = (
        off_the_recordings(tmp_path, hand) for hand in ("contact/hand.toml", "hannes")
    )
    assert as_found < 0.5 * shipped


def off_the_recordings(folder, hand):
    """RMS of the current [A] that `hannes run` writes, of the recordings' mean."""
    experiment = library.find("dynamometer").read_text(encoding="utf-8").replace("10 mA", "0 A")
    (folder / "bench.toml").write_text(experiment.replace('"hannes"', f'"{hand}"'))
    assert main(["run", str(folder / "bench.toml"), "--out", str(folder / "ran")]) == 0
    made = virtual_recordings(shipped_runs("dynamometer-runs")).values()
    recorded = np.mean([each["current"] for each in made], axis=0)
    ran = Recording.read(folder / "ran" / "recording.h5")["current"]
    return float(np.sqrt(np.mean((ran - recorded) ** 2)))


@pytest.mark.slow
def test_contact_from_the_papers_figures_alone_after_a_scan(tmp_path):
    """Moment of contact, slope of the current and both peaks: rough to search, so points first."""
    campaign = tmp_path / "campaign.toml"
    runs = f'file = "simulated:{shipped_runs("dynamometer-runs")}"\ncondition = "dynamometer"'
    asked = 'parameters = ["object.stiffness", "object.friction"]\nchannels = []\ndoubt = "0 %"\n'
    asked += 'features = ["contact", "I_max", "I_sc", "F_max"]'
    campaign.write_text(f"[[recording]]\n{runs}\n[calibrate]\n{asked}\n", encoding="utf-8")
    found = calibrate(campaign, progress=False)
    assert found.found.plan.scan == 64 and found.fitted_gap == {}
    for each, true in zip(found.answers, (30000.0, 0.45), strict=True):
        assert each.value == pytest.approx(true, rel=0.05) != each.nominal
        assert each.low < true < each.high


@pytest.mark.slow
def test_closing_time_and_position_identify_none_of_the_papers_frictions():
    found = calibrate("closure-friction", progress=False)
    assert len(found.answers) == 9
    assert not any(each.identified for each in found.answers)


@pytest.mark.slow
def test_the_real_axis_refitted_predicts_the_other_file():
    try:
        third_party.folder("emps")
    except MissingRecording as missing:
        pytest.skip(f"needs the EMPS recordings: {missing}")
    found = calibrate("emps", progress=False)
    fitted, other = (
        100.0 * gap["drive"]["after"] / gap["drive"]["recorded"]
        for gap in (found.fitted_gap, found.gap)
    )
    assert fitted <= 4.5 and other <= 5.4
    assert found.spread.unit == "segments of one run"


@pytest.mark.slow
def test_control_c_keeps_the_best_so_far(tmp_path, monkeypatch, capsys):
    campaign, out = tmp_path / "campaign.toml", tmp_path / "out"
    runs = f'file = "simulated:{shipped_runs("dynamometer-runs")}"\ncondition = "dynamometer"'
    asked = 'parameters = ["object.stiffness", "object.friction"]\nstarts = 8\ndoubt = "0 %"'
    campaign.write_text(f"[[recording]]\n{runs}\n[calibrate]\n{asked}\n", encoding="utf-8")
    misfits = interrupting(monkeypatch, "starts")
    assert main(["calibrate", str(campaign), "--out", str(out)]) == 130
    assert "Traceback" not in capsys.readouterr().err
    found = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    assert found["status"] == "interrupted" and min(misfits) < misfits[0]
    assert found["parameters"]["object.stiffness"]["value"] != Hand().parameters["object.stiffness"]


def interrupting(monkeypatch, text):
    """Press Ctrl-C once, at the fifth value that the progress shows in the part named `text`."""
    values = []

    @contextmanager
    def bar(title, unit, progress):
        def report(part, rms):
            if part == text:
                values.append(float(rms.removeprefix("RMS ")))
                if len(values) == 5:
                    signal.raise_signal(signal.SIGINT)

        yield report

    monkeypatch.setattr(sys.modules["hannes.commands.calibrate"], "stages", bar)
    return values


def test_a_campaign_of_another_plant_is_refused(tmp_path):
    campaign = tmp_path / "campaign.toml"
    file = shipped_runs("closure-runs")
    campaign.write_text(f'plant = "axis"\n[[recording]]\nfile = "simulated:{file}"\n')
    from hannes.core.errors import BadInput

    with pytest.raises(BadInput, match="a recording of the plant"):
        read_campaign(campaign)


# Relative steps as a fit takes them, half of what it ends up not knowing.
STEPS = {
    "motor.torque_constant": 1e-3,
    "mcp.coulomb_friction": 2e-2,
    "object.stiffness": 5e-3,
    "object.friction": 5e-3,
}


@pytest.mark.slow
def test_slopes_by_the_steps_of_a_fit_are_free_of_solver_errors(monkeypatch):
    """Against the same differences of runs that are converged, each bin weighed as in a fit."""
    run = next(iter(virtual_recordings(shipped_runs("dynamometer-runs")).values()))
    plant = hand_plant.HandPlant()
    view = View(Entry("run", run, "", "fit"), plant, ("current", "force"), ())
    model, steps = Model(plant, [view]), {n: plant.parameters[n] * s for n, s in STEPS.items()}
    used = model.bundle({}, steps)
    monkeypatch.setattr(hand_plant, "TOLERANCE", 1e-9)
    exact = model.bundle({}, steps)
    noise = np.hypot(
        0.01 * np.array([3.0, 200.0])[view.part],
        CALIBRATION.nonlinearity * view.nonlinearities(exact.centre[0]),
    )
    for name in STEPS:
        found = (model.derivatives(each, {name: 1.0}, np.zeros(1)) for each in (used, exact))
        a, b = (slopes[0][0] / noise for slopes in found)
        assert np.linalg.norm(a - b) < 0.02 * np.linalg.norm(b), name


def test_a_bin_of_one_last_sample_does_not_count():
    """Its mean is as noisy as that sample: counted like the rest, it would outweigh them."""
    run = next(iter(virtual_recordings(shipped_runs("dynamometer-runs")).values()))
    plant = hand_plant.HandPlant()
    view = View(Entry("run", run, "", "fit"), plant, ("current",), ())
    samples = round(BIN / float(np.median(np.diff(run.time))))
    whole, over = divmod(len(run), samples)
    assert over == 1
    assert view.bins == whole


def test_quick_runs_of_firmware_are_as_good_as_those_of_a_plant(monkeypatch):
    """Small changes of friction average the firmware's rounding out of both."""
    run = next(iter(virtual_recordings(shipped_runs("dynamometer-runs")).values()))
    asked = replace(experiment_of(run), controller="sampled")
    shipped = hand_plant.HandPlant().hand
    shares = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal(40)
    columns = {"motor.dry_friction": shipped.parameters["motor.dry_friction"] * shares}

    def mean_force() -> np.ndarray:
        made = batch_runs.many(shipped, asked, run, columns, ("force",), exact=True)
        return np.mean([each["force"] for each in made], axis=0)

    used = mean_force()
    monkeypatch.setattr(batch_runs, "TOLERANCE", 1e-7)
    exact = mean_force()
    assert np.sqrt(np.mean((used - exact) ** 2)) < 1.2e-4 * exact.max()


def test_derivatives_by_weak_parameters_are_no_noise(monkeypatch):
    """Forty such parameters would let a base bend to anything."""
    run = next(iter(virtual_recordings(shipped_runs("dynamometer-runs")).values()))
    plant = hand_plant.HandPlant()
    usual = plant.parameters["motor.inductance"]
    more = {"motor.inductance": usual * np.array([1.0, 0.98, 1.01, 1.015, 1.02, 1.03])}

    def slopes(tolerance):
        monkeypatch.setattr(batch_runs, "TOLERANCE", tolerance)
        runs = [each["current"] for each in plant.many(more, run, ("current",), exact=False)]
        return np.array(runs[1:]) - runs[0]

    used, wide, right = map(slopes, (batch_runs.TOLERANCE, batch_runs.WIDE, 1e-8))
    size = np.linalg.norm(right, axis=1)  # one pair's noise is as it happens: the middle of five
    assert np.median(np.linalg.norm(used - right, axis=1) / size) < 0.7
    assert np.median(np.linalg.norm(wide - right, axis=1) / size) > 2.0
