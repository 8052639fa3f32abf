"""Every code block of README and docs runs, or is marked as output."""

import pytest
from pages import PAGES, blocks, name, run

# What a diagnosis of a hand takes, or training: run by `make test-all`.
SLOW = {"README.md", "docs/tutorials/your-recordings.md", "docs/tutorials/classifier.md"}


def _marked(page):
    return pytest.param(page, id=name(page), marks=[pytest.mark.slow] if name(page) in SLOW else [])


@pytest.mark.parametrize("page", [_marked(each) for each in PAGES if blocks(each)])
def test_every_code_block_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run(page, tmp_path)


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
