"""The notebooks in examples/notebooks run from top to bottom and show what they say."""

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def executed(name, folder, monkeypatch):
    """Run a notebook in a copy of the examples; return the HTML and text of all of its outputs."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    shutil.copytree(ROOT / "examples", folder / "examples")
    here = folder / "examples" / "notebooks"
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
    book = nbformat.read(here / f"{name}.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in book.cells)  # they are kept without
    client = nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(here)}})
    client.execute()
    outputs = [each for cell in book.cells for each in cell.get("outputs", ())]
    pictures = sum("image/png" in each.get("data", {}) for each in outputs)
    words = "\n".join(
        each.get("text", "") + "".join(map(str, each.get("data", {}).values())) for each in outputs
    )
    return words, pictures, here


@pytest.mark.slow
def test_first_grasp(tmp_path, monkeypatch):
    words, pictures, here = executed("first_grasp", tmp_path, monkeypatch)
    assert pictures == 3
    assert "<svg" in words and "completed" in words and "leader_slack" in words
    assert (here / "results" / "slack.html").stat().st_size < 1e6


@pytest.mark.slow
def test_diagnosis(tmp_path, monkeypatch):
    words, pictures, here = executed("diagnosis", tmp_path, monkeypatch)
    assert pictures == 2
    assert "rail friction" in words.lower() and "RMS gap" in words
    assert (here / "results" / "verdict" / "report.html").exists()
