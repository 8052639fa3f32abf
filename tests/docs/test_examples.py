"""Examples outside the package: they take all that they need of hannes from `hannes` itself."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import hannes
from hannes.commands.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
GREASE = EXAMPLES / "own_effect"
FILES = sorted(EXAMPLES.rglob("*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: "/".join(file.parts[-2:]))
def test_an_example_imports_public_names_only(file):
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert all(each.name.partition(".")[0] != "hannes" for each in node.names)
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "hannes":
            assert node.module == "hannes"
            assert {each.name for each in node.names} <= set(hannes.__all__)


def test_an_effect_a_plant_and_an_experiment_of_ones_own_are_among_them():
    used = {
        each.name
        for file in FILES
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module == "hannes"
        for each in node.names
    }
    assert {"Effect", "Term", "kernel", "PlainPlant", "Experiment", "Reference"} <= used


def test_the_effect_is_one_that_a_run_takes_and_the_experiment_has_it(monkeypatch, capsys):
    monkeypatch.chdir(GREASE)
    assert main(["effects", "grease.py:EFFECT"]) == 0
    assert capsys.readouterr().out.startswith("thick_grease\n")
    (asked,) = hannes.load_experiment("grasp.toml", trust=True)
    assert [each.name for each in asked.hand.effects] == ["thick_grease"]
    assert "gear_friction += thick_grease__drag(" in asked.hand.equations()


@pytest.mark.slow
def test_the_script_says_what_the_grease_takes_away():
    """A model that is compiled for it alone."""
    path = os.pathsep.join([str(EXAMPLES.parent), *sys.path])
    run = subprocess.run(
        [sys.executable, "compare.py"],
        cwd=GREASE,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    grip, amperes = (
        {line.split(": ")[0]: float(line.split(": ")[1].split()[0])
         for line in run.stdout.splitlines() if f"{unit} at most" in line}
        for unit in ("N", "A")
    )  # fmt: skip
    assert 5.0 < grip["with grease"] < grip["without"]
    more = amperes["with grease"] - amperes["without"]
    motor_speed = hannes.Hand().parameters["gear.ratio"] * 4.6 / 0.6  # rad/s
    drag = 1e-7 * motor_speed**2  # N m, as grasp.toml has it
    assert more == pytest.approx(drag / hannes.Hand().parameters["motor.torque_constant"], rel=0.12)
    assert "MovedWarning" not in run.stderr
