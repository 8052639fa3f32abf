"""README is short, sentences are short, and no page speaks a language of its own."""

import re

import pytest
from pages import PAGES, ROOT, name, prose, sentences, text

README = ROOT / "README.md"
HOME_MADE = (
    *("told", "felt", "hollow", "bent", "restless", "nameless", "strain", "grain", "passages"),
    *("put in", "from afar", "worked out"),
)


def test_readme_has_at_most_900_words():
    assert len(text(README).split()) <= 900


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_sentences_have_at_most_20_words_on_average(page):
    if found := [len(each.split()) for each in sentences(page)]:
        assert sum(found) / len(found) <= 20, sorted(
            sentences(page), key=lambda s: -len(s.split())
        )[:3]


@pytest.mark.parametrize("page", [p for p in PAGES if "Written by" not in text(p)], ids=name)
def test_no_page_has_a_language_of_its_own(page):
    for word in HOME_MADE:
        assert not re.search(rf"(?<![`\w.]){word}(?![`\w])", prose(page), re.IGNORECASE), word
