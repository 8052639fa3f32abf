"""README.md stays true: its figure is today's, its Python runs, its figures are what is printed."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FEWEST = 30  # points of a drawn curve; frames, ticks and letters have fewer


def curves(svg):
    """Points of every drawn curve, shape (n, 2) in px each."""
    paths = (each.get("d", "") for each in ElementTree.fromstring(svg).iter() if "path" in each.tag)
    found = [np.array(re.findall(r"[ML] ([\d.-]+) ([\d.-]+)", path), float) for path in paths]
    return [each for each in found if len(each) >= FEWEST]


def test_the_figure_is_todays():
    """docs/grasp.svg is figure 8 of `hannes reproduce`; `make docs` draws it anew."""
    from hannes.report.paper.figure_grasp import dynamometer
    from hannes.simulation.experiment.load import load_experiment
    from hannes.simulation.simulate import simulate

    (grasp,) = load_experiment("dynamometer")
    now = dynamometer(simulate(grasp.hand, grasp.experiment).require()).svg
    kept = (ROOT / "docs" / "grasp.svg").read_text(encoding="utf-8")
    assert len(curves(kept)) == len(curves(now)) == 2  # current and force
    for old, new in zip(curves(kept), curves(now), strict=True):
        across = np.linspace(new[0, 0], new[-1, 0], 500)
        apart = np.interp(across, *old.T) - np.interp(across, *new.T)
        assert np.abs(apart).max() < 0.5, "run `make docs`"


@pytest.mark.slow
def test_the_python_runs(tmp_path, monkeypatch, capsys):
    """The block in the section for library users, on a campaign of the axis."""
    from axis_campaign import campaign

    monkeypatch.chdir(tmp_path)
    campaign(tmp_path, ["fit", "select", "show"])
    (block,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    exec(compile(block, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    for said in (
        "Stages of the model",
        "vanishes at 0",
        " N at 0.",
        "source",
        "Direction friction",
    ):
        assert said in printed
    assert (tmp_path / "ball.h5").exists()


def test_all_of_the_python_comes_from_hannes():
    import hannes

    (block,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert set(re.findall(r"^(?:from|import) (\S+)", block, flags=re.MULTILINE)) == {"hannes"}
    assert all(getattr(hannes, name) is not None for name in hannes.__all__)


def figures():
    """Rows of the table of figures: what is measured -> the number in its second column."""
    rows = re.findall(r"^\| (.+?) \| ([\d.]+) [^|]*\| [^|]+\|$", README, flags=re.MULTILINE)
    return {text: number for text, number in rows}


def shown(value):
    """As `hannes reproduce` prints it."""
    return f"{value:.3g}"


def row(start):
    """The number of the one row that starts with these words."""
    (found,) = [number for text, number in figures().items() if text.startswith(start)]
    return found


def test_the_figures_are_what_reproduce_prints():
    from hannes.report.paper.checks import must_show
    from hannes.report.paper.energy import energy_row
    from hannes.report.paper.runs import run_all

    found = {each["name"]: each["value"] for each in must_show(run_all(progress=False, quick=True))}
    errors = [value for name, value in found.items() if name.endswith("off Table II's Hannes row")]
    assert len(errors) == 6 and row("the five current metrics") == shown(max(errors))
    assert row("first force above 1 N") == shown(found["first force above 1 N, off 0.30 s"])
    assert row("void current") == shown(found["void current of the unit, off 0.25 A"])
    energy = energy_row(progress=False)
    assert row("energy unaccounted for") == shown(energy["value"])
    assert re.search(r"worst of (?:the )?(\d+) runs", README)[1] in energy["name"]


def test_the_figures_of_the_real_axis_are_what_reproduce_prints():
    from hannes import diagnose
    from hannes.campaigns import third_party
    from hannes.commands.reproduce import force_errors
    from hannes.core.errors import MissingRecording

    try:
        third_party.folder("emps")
    except MissingRecording as missing:
        pytest.skip(f"needs the EMPS recordings: {missing}")
    result = diagnose("emps")
    fitted, other = (force_errors(each) for each in result.traces)
    assert row("EMPS, published symmetric") == shown(fitted[0])
    assert row("the same on the other file") == shown(other[0])
    assert row("EMPS, other file: the effect") == shown(other[1] - other[2])
    assert f"({shown(other[1])}, then {shown(other[2])} %)" in README
    for share in ("dry", "viscous"):
        size = result.verdict.parameters[f"direction_friction.{share}"]
        digits = {"dry": ".2g", "viscous": ".3g"}[share]
        low, value, high = (format(size[key], digits) for key in ("low", "value", "high"))
        assert f"{value} ({low} to {high})" in README
    assert "Not distinguishable from no effect: dry" in result.verdict.sentence
