"""README and the page of evidence stay true: pictures are today's, figures are what is printed."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from pages import ROOT, blocks, text

from hannes.commands.cli import make_parser

README = text(ROOT / "README.md")
REFERENCE = ROOT / "docs" / "reference"
EVIDENCE = text(ROOT / "docs" / "explanation" / "evidence.md")
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


def test_the_schematic_is_todays():
    """docs/hand.svg is what `hannes hand --schematic` prints; `make docs` draws it anew."""
    from hannes.report.schematic import schematic

    assert text(ROOT / "docs" / "hand.svg") == schematic(), "run `make docs`"


def test_all_of_the_python_comes_from_hannes():
    import hannes

    (block,) = (each.text for each in blocks(ROOT / "README.md") if each.language == "python")
    assert set(re.findall(r"^(?:from|import) (\S+)", block, flags=re.MULTILINE)) == {"hannes"}
    assert all(getattr(hannes, name) is not None for name in hannes.__all__)


def test_every_command_stands_in_its_table():
    """`make release-check` runs them all from an empty folder."""
    known = re.findall(r"^## hannes ([\w-]+)$", text(REFERENCE / "commands.md"), re.MULTILINE)
    assert len(known) > 15
    assert [each for each in known if f"`hannes {each}" not in README] == []


def test_the_commands_of_its_table_are_commands():
    lines = re.findall(r"`hannes ([^`]+)`", README)
    assert len(lines) > 12
    for line in lines:
        if line != "COMMAND --help":
            assert make_parser().parse_args(line.split()).command


def figures():
    """Rows of the table of figures: what is measured -> the number in its second column."""
    rows = re.findall(r"^\| (.+?) \| ([\d.]+) [^|]*\| [^|]+\|$", EVIDENCE, flags=re.MULTILINE)
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
    assert re.search(r"worst of (?:the )?(\d+) runs", EVIDENCE)[1] in energy["name"]


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
    assert f"({shown(other[1])}, then {shown(other[2])} %)" in EVIDENCE
    for share in ("dry", "viscous"):
        size = result.verdict.parameters[f"direction_friction.{share}"]
        digits = {"dry": ".2g", "viscous": ".3g"}[share]
        low, value, high = (format(size[key], digits) for key in ("low", "value", "high"))
        assert f"{value} ({low} to {high})" in EVIDENCE
    assert "Not distinguishable from no effect: dry" in result.verdict.sentence
