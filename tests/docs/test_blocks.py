"""Every code block of README and docs runs, or is marked as output."""

import shutil
import subprocess
import sys

import pytest
from pages import PAGES, ROOT, blocks, name, run

README = "README.md"  # reads the examples of the project
CHECKOUT = "docs/how-to/add-an-effect.md"  # writes into a copy of the project
# What takes the model with all effects, or training, or models of one's own: by `make test-all`.
SLOW = {
    README,
    "docs/how-to/calibrate.md",
    "docs/how-to/hold-and-move-objects.md",
    "docs/tutorials/classifier.md",
    "docs/tutorials/your-effect.md",
    "docs/tutorials/your-recordings.md",
    CHECKOUT,
}


def _marked(page):
    return pytest.param(page, id=name(page), marks=[pytest.mark.slow] if name(page) in SLOW else [])


@pytest.mark.parametrize("page", [_marked(each) for each in PAGES if blocks(each)])
def test_every_code_block_runs(page, tmp_path, monkeypatch, capsys):
    if name(page) == CHECKOUT:
        copied(tmp_path)
        monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    if name(page) == README:
        shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)  # as where `python` is typed
    try:
        run(page, tmp_path)
    finally:
        for each, module in list(sys.modules.items()):  # of another page there may be one like it
            if str(getattr(module, "__file__", "")).startswith(str(tmp_path)):
                del sys.modules[each]


def copied(folder):
    """The project's own files in a folder."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    for file in listed.stdout.splitlines():
        if (ROOT / file).is_file():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, folder / file)


def test_a_block_that_fails_is_seen(tmp_path, monkeypatch):
    import pages

    page = tmp_path / "page.md"
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pages, "ROOT", tmp_path)
    for wrong in ("```sh\nhannes effects no_such\n```", "```sh\nls\n```", "```bash\nls\n```"):
        page.write_text(wrong + "\n", encoding="utf-8")
        with pytest.raises(AssertionError):
            run(page, tmp_path)
    page.write_text("```python\nx = 1\n```\nand\n```python\nassert x == 2\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError):
        run(page, tmp_path)
