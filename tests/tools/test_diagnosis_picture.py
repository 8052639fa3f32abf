"""The README's picture of a diagnosis is one figure of its page, and nothing else."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from tools.diagnosis_picture import picture

PAGE = """<figure id="diagnosis-position">
<svg viewBox="0 0 10 20" role="img"><path d="M 1.26 2 L 3.44 4" id="p1.25"/></svg>
</figure>"""


def test_it_stands_alone_with_coordinates_of_a_tenth():
    drawn = picture(PAGE)
    root = ElementTree.fromstring(drawn)
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    (path,) = root
    assert path.get("d") == "M 1.3 2 L 3.4 4" and path.get("id") == "p1.25"


def test_a_page_without_it_is_refused():
    with pytest.raises(SystemExit, match="no figure diagnosis-duty"):
        picture(PAGE, "diagnosis-duty")


def test_the_picture_that_is_kept_is_small_and_has_the_words_of_today():
    kept = (Path(__file__).parents[2] / "docs" / "diagnosis.svg").read_text(encoding="utf-8")
    assert len(kept) < 60_000
    for words in ("measured", "as given", "baseline refitted", "residual [rad]", "noise floor"):
        assert words in kept
