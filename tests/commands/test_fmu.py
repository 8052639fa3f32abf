"""The FMU of a hand: it passes FMPy's validation, and its trace is that of `simulate`."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hannes import load_experiment, simulate
from hannes.commands.cli import main
from hannes.plants.hand.fmu_slave import OUTPUTS

pytest.importorskip("pythonfmu")
fmpy = pytest.importorskip("fmpy")

STEP, END = 1e-3, 0.35  # s
LAST = 1.15  # s, of the experiment


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    path = tmp_path_factory.mktemp("fmu") / "hand.fmu"
    assert main(["fmu", "dynamometer", "--out", str(path)]) == 0
    return path


def run(made, end=END, **options):
    times = {"start_time": 0.0, "stop_time": end, "step_size": STEP, "output_interval": STEP}
    return fmpy.simulate_fmu(str(made), **times, **options)


def test_description_is_valid(made):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(made)) == []
    description = fmpy.read_model_description(str(made))
    units = {each.name: each.unit for each in description.modelVariables}
    assert (units["position"], units["current"], units["leader_tension"]) == ("rad", "A", "N")
    assert all(each.description for each in description.modelVariables)
    assert float(description.defaultExperiment.stopTime) == LAST


def test_trace_is_that_of_simulate_to_the_bit(made):
    asked = load_experiment("dynamometer")[0]
    ran = simulate(asked.hand, replace(asked.experiment, controller="sampled", noise={}))
    found = run(made, LAST)
    assert len(found) == round(LAST / STEP) + 1 == len(ran)
    for name in OUTPUTS:
        assert np.array_equal(found[name][:-1], ran[name][:-1]), name
        if name != "duty":  # of the tick at the end, which `simulate` does not make
            assert found[name][-1] == pytest.approx(ran[name][-1], rel=1e-9), name
    assert abs(found["duty"][-1] - ran["duty"][-1]) < 0.01


def test_reference_comes_from_outside_where_that_is_asked_for(made):
    """The same command through the input gives nearly the same; another gives another."""
    times = np.arange(0.0, END + STEP, STEP)
    rows = [(t, 9.84 * t / 0.637) for t in times]
    ramp = np.array(rows, [("time", float), ("reference", float)])
    given = run(made, start_values={"own_reference": False}, input=ramp)
    own = run(made)
    assert 0.0 < np.abs(given["position"] - own["position"]).max() < 0.03  # a tick late
    still = run(made, start_values={"own_reference": False, "reference": 0.0})
    assert np.abs(still["position"]).max() < 0.01 < own["position"].max()


def test_several_simulations_are_refused(tmp_path, capsys):
    assert main(["fmu", "stiffness-sweep", "--out", str(tmp_path / "no.fmu")]) == 2
    assert "an FMU is one hand" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_effects_of_a_file_are_refused(tmp_path, capsys):
    """It would run wherever the FMU goes."""
    effect = Path(__file__).parents[2] / "examples" / "own_effect"
    own = effect / "grease.py"
    name = re.search(r"^(\w+) = Effect\(", own.read_text(encoding="utf-8"), re.MULTILINE)[1]
    (tmp_path / "own.toml").write_text(
        f'effects = ["{own}:{name}"]\nduration = "0.1 s"\n[reference]\nkind = "ramp"\n'
        'points = [["0 s", "0 rad"], ["0.1 s", "1 rad"]]\n',
        encoding="utf-8",
    )
    asked = ["fmu", str(tmp_path / "own.toml"), "--out", str(tmp_path / "no.fmu"), "--trust"]
    assert main(asked) == 2
    assert "only effects that ship" in capsys.readouterr().err
