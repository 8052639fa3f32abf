"""`hannes compare`: Table II and equation 4 of the paper, for recordings as a bench writes them."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from hannes import Hand, compare, load_experiment, observe, simulate
from hannes.commands.cli import main
from hannes.core.recording.recording import Recording
from hannes.identification.comparison.aligned_run import command_start
from hannes.identification.comparison.spread import spread
from hannes.simulation.grasp_metrics import closing_time, grasp_metrics, void_current

PULLEY = "gear.pulley_radius"
NOISE = {"current": 0.01, "force": 0.05, "position": 1e-4}
LATE = 0.2  # s for which a logger of the grasps waited before the command

ROW = """
[[recording]]
file = "{file}"
experiment = "{experiment}"
condition = "{condition}"
"""


def made(name, values, seed):
    """A run of a shipped experiment by a hand with other values, logged with noise."""
    (variant,) = load_experiment(name)
    hand = Hand().with_values(values)
    experiment = replace(variant.experiment, noise=NOISE, seed=seed)
    return observe(hand, simulate(hand, experiment).require())


def kept(recording, names, late=0.0):
    """Some channels as measured, from a logger that started early and held still until then."""
    before = np.arange(0.0, late - 1e-9, 1e-3)
    still = np.random.default_rng(0).standard_normal((len(names), before.size))
    time = np.concatenate([before, recording.time + late])
    held = {
        n: np.concatenate([recording[n][0] + NOISE.get(n, 0.0) * still[k], recording[n]])
        for k, n in enumerate(names)
    }
    units = {n: recording.units[n] for n in ("time", *names)}
    return Recording({"time": time, **held}, units)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Closures of two units, two runs each, two grasps of the dynamometer, one of a soft ball."""
    folder = tmp_path_factory.mktemp("bench")
    values = {"left": {}, "right": {"motor.dry_friction": 3.5e-3}}
    free, grasp = (
        ("reference", "position", "current"),
        ("reference", "position", "current", "force"),
    )
    text, truth = "", {}
    for unit, differs in values.items():
        for k in range(2):
            run = made("void-closure", differs, 2 * k + len(unit))
            file = f"{unit}_{k}.csv"
            kept(run, free).write(folder / file)
            truth[file] = run
            row = ROW.format(file=file, experiment="void-closure", condition="void")
            text += f'{row}unit = "{unit}"\n'
    for k, name in enumerate(("dynamometer", "dynamometer", "soft-ball")):
        truth[f"grasp_{k}.csv"] = run = made(name, {PULLEY: 5.0e-3}, k)
        kept(run, grasp, LATE).write(folder / f"grasp_{k}.csv")
        text += ROW.format(file=f"grasp_{k}.csv", experiment=name, condition=name)
    (folder / "campaign.toml").write_text(text)
    return folder, truth


@pytest.fixture(scope="module")
def result(bench, tmp_path_factory):
    """The comparison of that campaign, and the folder that it was written to."""
    out = tmp_path_factory.mktemp("compared") / "out"
    return compare(bench[0] / "campaign.toml", out=out), out


def test_each_metric_is_that_of_the_run_as_it_was_made(bench, result):
    """Also where the logger started before the command."""
    (grasps,) = (each for each in result[0].conditions if each.name == "dynamometer")
    for each in grasps.runs:
        run = bench[1][each.run.entry.name]
        expected = grasp_metrics(run.time, run["current"], run["force"], run["position"])
        assert each.run.shift == pytest.approx(LATE, abs=1.1e-3)
        for name, pair in each.pairs.items():
            assert pair.measured == pytest.approx(getattr(expected, name), rel=5e-3), name
    (void,) = (each for each in result[0].conditions if each.name == "void")
    for each in void.runs:
        run = bench[1][each.run.entry.name]
        taken = closing_time(run.time, run["position"])
        level = void_current(run.time, run["current"])
        assert each.pairs["closing time"].measured == pytest.approx(taken, rel=2e-3)
        assert each.pairs["void current"].measured == pytest.approx(level, rel=2e-3)


def test_the_simulation_is_the_campaigns_hand_under_the_same_command(result):
    (variant,) = load_experiment("dynamometer")
    run = simulate(Hand(), variant.experiment).require()
    expected = grasp_metrics(run.time, run["current"], run["force"], run["position"])
    (grasps,) = (each for each in result[0].conditions if each.name == "dynamometer")
    rows = {row.metric: row for row in grasps.rows}
    assert set(rows) == {"contact", "I_avgc", "I_avgo", "I_max", "I_sc", "I_so", "F_max"}
    for name, row in rows.items():
        assert row.simulated.mean == pytest.approx(getattr(expected, name), rel=0.01), name


def test_equation_4_has_its_sign(result):
    for condition in result[0].conditions:
        for row in condition.rows:
            off = 100.0 * (row.measured.mean - row.simulated.mean) / row.measured.mean
            assert row.error == pytest.approx(off)
    (void,) = (each for each in result[0].conditions if each.name == "void")
    right = {row.metric: row for row in void.by_unit["right"]}["void current"]
    left = {row.metric: row for row in void.by_unit["left"]}["void current"]
    assert right.error < -3.0 < left.error  # less friction than the hand of the campaign


def test_an_error_that_no_model_has_is_doubted(result):
    from hannes.report.comparison import sentence

    compared = result[0]
    assert "no gap of the model" not in sentence(compared)
    condition = compared.conditions[0]
    for factor in (5.24, 0.1, -1.0):  # too large, too small, the other way
        row = condition.rows[0]
        simulated = replace(row.simulated, mean=factor * row.measured.mean)
        row = replace(row, simulated=simulated, error=100.0 * (1.0 - factor))
        far = replace(compared, conditions=(replace(condition, rows=(row,)),))
        assert "may be no gap of the model" in sentence(far)


def test_spread_of_repeats_is_apart_from_that_of_units():
    found = spread({"left": [1.0, 3.0], "right": [7.0, 9.0]})
    assert found.mean == 5.0 and found.runs == 4
    assert found.repeats == pytest.approx(np.sqrt(2.0))
    assert found.units == pytest.approx(np.std([2.0, 8.0], ddof=1))
    single = spread({"": [4.0]})
    assert (single.mean, single.repeats, single.units) == (4.0, None, None)


def test_without_repeats_it_says_so(result):
    content = result[0].plain()
    repeats = {each["condition"]: each["repeats"] for each in content["conditions"]}
    assert repeats == {"void": True, "dynamometer": True, "soft-ball": False}
    assert any("No repeats of soft-ball" in each for each in content["notes"])


def test_what_has_no_meaning_is_left_out_with_the_reason(result):
    (soft,) = (each for each in result[0].plain()["conditions"] if each["condition"] == "soft-ball")
    assert "I_so" not in soft["metrics"] and "I_max" in soft["metrics"]
    (why,) = soft["left_out"]
    assert why["metric"] == "I_so" and "800 N/m" in why["reason"]


@pytest.mark.parametrize(
    ("change", "gone", "why"),
    [
        ("no force", {"contact", "I_avgc", "I_avgo", "I_sc", "F_max"}, "no force was recorded"),
        ("no current", {"I_avgc", "I_avgo", "I_max", "I_sc", "I_so"}, "no current was recorded"),
        ("no position", {"I_avgo"}, "no position was recorded"),
        ("no contact", "all", "no contact: the force stays below 1 N in the recording"),
        ("offset", "all", "contact cannot be determined"),
        ("spikes", "all", "contact cannot be determined"),
        ("still", "all", "the command does not close the hand"),
    ],
)
def test_reasons_of_a_grasp(result, change, gone, why):
    from hannes.identification.comparison.run_metrics import run_metrics

    (grasps,) = (each for each in result[0].conditions if each.name == "dynamometer")
    run = grasps.runs[0].run
    channels = dict(run.measured)
    channels["force"] = {
        "no contact": np.zeros(run.time.size),
        "offset": run.measured["force"] + 2.0,
        "spikes": run.measured["force"] + 2.0 * (np.arange(run.time.size) % 50 == 7),
    }.get(change, run.measured["force"])
    if change in ("no force", "no current", "no position"):
        del channels[change.removeprefix("no ")]
    still = np.zeros(run.time.size) if change == "still" else run.reference
    found = run_metrics(replace(run, measured=channels, reference=still))
    everything = {"contact", "I_avgc", "I_avgo", "I_max", "I_sc", "I_so", "F_max"}
    gone = everything if gone == "all" else gone
    assert set(found.left_out) == gone and set(found.pairs) == everything - gone
    assert all(why in each for each in found.left_out.values())


def test_a_dynamometer_alone_takes_the_place_of_the_force(bench, tmp_path):
    run = next(each for name, each in bench[1].items() if name == "grasp_0.csv")
    kept(run, ("reference", "position", "current", "sensor")).write(tmp_path / "r.csv")
    row = ROW.format(file="r.csv", experiment="dynamometer", condition="grasp")
    (tmp_path / "campaign.toml").write_text(row)
    found = compare(tmp_path / "campaign.toml")
    ((measured,),) = ([each.pairs for each in one.runs] for one in found.conditions)
    assert measured["F_max"].measured == pytest.approx(run["sensor"].max())
    (variant,) = load_experiment("dynamometer")
    model = simulate(Hand(), variant.experiment).require()
    assert measured["F_max"].simulated == pytest.approx(model["sensor"].max(), rel=2e-3)
    assert model["sensor"].max() > 1.01 * model["force"].max()  # so the two are not confused
    assert any("sensor_N" in each for each in found.notes)


def test_a_closure_that_touches_is_none(result):
    from hannes.identification.comparison.run_metrics import run_metrics

    (void,) = (each for each in result[0].conditions if each.name == "void")
    run = void.runs[0].run
    force = np.where(run.time > 0.3, 5.0, 0.0)
    touched = replace(run, measured={**run.measured, "force": force})
    assert set(run_metrics(touched).left_out) == {"closing time", "void current"}


def test_a_command_starts_where_it_first_moves():
    ramp = np.concatenate([np.full(30, 0.2), np.linspace(0.2, 9.0, 500)])
    assert command_start(ramp) == 30
    assert command_start(np.zeros(9)) == 0


def test_the_page_stands_alone_and_shows_both(result):
    text = (result[1] / "index.html").read_text(encoding="utf-8")
    figures = re.findall(r'<figure id="([^"]+)"', text)
    assert figures == ["fig6-1", "fig7-1", "fig8-2", "fig8-3"]
    assert "<script" not in text and not re.findall(r'(?:src|href)="?https?:', text)
    assert "Table II: dynamometer" in text and "By unit: void" in text
    assert "least-squares slope" in text and text.count("simulated</text>") == 4


def test_the_command_prints_the_table_and_refuses_what_is_not_its_own(bench, tmp_path, capsys):
    campaign, out = str(bench[0] / "campaign.toml"), str(tmp_path / "out")
    assert main(["compare", campaign, "--out", out, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((tmp_path / "out" / "compare.json").read_text())
    assert content["definitions"]["F_max"]
    assert main(["compare", campaign, "--out", out]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"I_max \[A\] +2\.\d+ +0\.\d+ +- +2\.\d+ +[+-]\d+\.\d", printed)
    assert printed.startswith("Largest relative error: ")  # the worst first
    assert "closing time, right [s]" in printed and "without I_so: the object is soft" in printed
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("precious")
    assert main(["compare", campaign, "--out", str(tmp_path / "mine")]) == 2


def test_another_machine_is_refused_in_one_line(tmp_path, capsys):
    time = np.linspace(0.0, 1.0, 400)
    channels = {"time": time, "reference": np.sin(time), "position": np.sin(time), "drive": time}
    units = {"time": "s", "reference": "m", "position": "m", "drive": "V"}
    Recording(channels, units).write(tmp_path / "r.csv")
    (tmp_path / "c.toml").write_text('plant = "axis"\n[[recording]]\nfile = "r.csv"\n')
    assert main(["compare", str(tmp_path / "c.toml"), "--out", str(tmp_path / "out")]) == 2
    assert "is no hand" in capsys.readouterr().err
