"""Version, citation and change log agree."""

import re

import yaml
from pages import ROOT, text

from hannes import __version__


def test_the_citation_is_valid_as_far_as_its_required_keys_go():
    cited = yaml.safe_load(text(ROOT / "CITATION.cff"))
    assert {"cff-version", "message", "title", "authors"} <= cited.keys()
    assert cited["version"] == __version__ and cited["license"] == "MIT"
    assert all("name" in each or "family-names" in each for each in cited["authors"])
    (paper,) = re.findall(r'"(.+)"', cited["abstract"])
    assert paper in " ".join(text(ROOT / "README.md").split())


def test_the_change_log_knows_this_version():
    assert re.search(rf"^## {re.escape(__version__)}", text(ROOT / "CHANGELOG.md"), re.MULTILINE)
