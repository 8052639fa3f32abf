"""Links inside the project lead somewhere, headings included."""

import re

import pytest
from pages import PAGES, ROOT, blocks, name, text

_LINK = re.compile(r"\[[^]]*\]\(([^)\s]+)\)")


def anchors(page):
    """Anchors of a page's headings, as GitHub makes them."""
    lines = re.findall(r"^#+ (.+)$", text(page), re.MULTILINE)
    plain = (re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", r"\1", line).strip().lower() for line in lines)
    return {re.sub(r"[^\w\- ]", "", each).replace(" ", "-") for each in plain}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_resolve(page):
    for link in _LINK.findall(text(page)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{name(page)} links to {link}"
        if anchor:
            assert anchor in anchors(target), f"{name(page)} links to {link}"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_files_that_are_named_exist(page):
    """`hannes/...`, `benchmarks/...` and the like in prose are files or folders."""
    for path in re.findall(
        r"`((?:hannes|benchmarks|tests|docs|examples|experiments|tools)/[\w./*-]+)`", text(page)
    ):
        if "NAME" in path:
            continue  # a file to be written
        found = list(ROOT.glob(path)) if "*" in path else [ROOT / path]
        assert found and found[0].exists(), f"{name(page)} names {path}"


def test_every_page_is_reached_from_the_index():
    index = ROOT / "docs" / "index.md"
    linked = {
        (index.parent / link.partition("#")[0]).resolve() for link in _LINK.findall(text(index))
    }
    inside = {page for page in PAGES if page.is_relative_to(ROOT / "docs") and page != index}
    assert inside <= linked


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_modules_that_are_named_exist(page):
    """`final_fit.py` and the like are a module somewhere, or a file that the page makes."""
    made = {block.file for block in blocks(page)}
    for module in re.findall(r"`(\w+\.py)`", text(page)):
        assert module in made or list(ROOT.glob(f"hannes/**/{module}")), f"{name(page)}: {module}"


def test_the_tables_of_the_verdict_page_are_made_where_contributing_says():
    page = text(ROOT / "hannes" / "report" / "diagnosis.py")
    section = text(ROOT / "CONTRIBUTING.md").partition("## A column on the verdict page")[2]
    rows = re.findall(r"^\| ([^|`]+) \| `(\w+)` \|$", section, re.MULTILINE)
    assert len(rows) == page.count(") -> Table:")
    for title, function in rows:
        assert f"def {function}(" in page and f'"{title}"' in page
