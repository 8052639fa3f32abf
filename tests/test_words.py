"""Former home-made words stand nowhere, nor do the identifiers that were renamed with them.

`renamed_identifiers.txt` beside this file has one line for each of those: former -> present name.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
RENAMED = Path(__file__).parent / "renamed_identifiers.txt"
FOLDERS = ("hannes", "benchmarks", "docs", "examples", "experiments", "tests", "tools", ".ci")
SUFFIXES = {".py", ".md", ".toml", ".html", ".j2", ".css", ".js", ".sh", ".c", ".ipynb"}
RECORDS = ROOT / "benchmarks" / "records"  # studies as their version wrote them

WORDS = {
    *("told", "tell", "tells", "telling", "untold"),
    *("felt", "unfelt", "hollow", "hollows", "hollowed", "bent", "unbent"),
    *("restless", "restlessly", "restlessness", "nameless", "namelessly"),
    *("strain", "strains", "strained", "straining", "unstrained"),
    *("grain", "grains", "grained", "grainy", "passage", "passages"),
}
PHRASES = re.compile(r"\b(?:puts?|putting) in\b|\bfrom afar\b|\bwork(?:s|ed|ing)? out\b")
CANDIDATE = re.compile(
    "told|tell|felt|hollow|bent|restless|nameless|strain|grain|passage|put|afar|work", re.IGNORECASE
)

# Where a word stays: file, what its line holds, why. At most 20 lines.
ALLOWED = (
    ("tests/test_words.py", "", "the list of these words"),
    ("tests/docs/test_prose.py", '("', "the list for pages"),
    ("tests/renamed_identifiers.txt", "", "the list of former identifiers"),
    ("hannes/plants/protocol.py", "restless", "users' plants have it; read with a warning"),
    ("docs/reference/python.md", "restless", "the same, on its generated page"),
    ("tests/plants/test_own_plant.py", "restless", "the test of it"),
    ("hannes/core/former_names.py", "told_", "users' effects name it; read with a warning"),
    ("hannes/core/former_modules.py", '": "', "users' files import it; loaded with a warning"),
    ("tests/core/test_public_names.py", "told_force", "the test of it"),
    ("benchmarks/naming_study/records.py", "FORMER", "a key of records on disk"),
    ("tests/benchmarks/test_naming_study.py", "told", "the test of it"),
)


@cache
def files() -> tuple[Path, ...]:
    """Code, docs and templates of the project."""
    found = [*ROOT.glob("*.md"), *ROOT.glob("*.toml"), *ROOT.glob("*.cff"), ROOT / "Makefile"]
    for folder in FOLDERS:
        found += [path for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES]
    return tuple(sorted(each for each in found if each.is_file() and RECORDS not in each.parents))


def home_made(line: str) -> list[str]:
    """Home-made words of a line, those within identifiers included."""
    if not CANDIDATE.search(line):
        return []
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", line).lower()
    words = re.findall(r"[a-z]+", parted)
    return [word for word in words if word in WORDS] + PHRASES.findall(" ".join(words))


@cache
def hits() -> tuple[tuple[str, int, str, tuple[str, ...]], ...]:
    """File, number, text and home-made words of every line that has some."""
    return tuple(
        (path.relative_to(ROOT).as_posix(), number, line, tuple(words))
        for path in files()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if (words := home_made(line))
    )


def used(text: str) -> Iterator[tuple[int, str]]:
    """Line and name of every identifier of a Python text."""
    for node in ast.walk(ast.parse(text)):
        for field in ("name", "id", "attr", "arg", "asname"):
            name = getattr(node, field, None)
            if isinstance(name, str):
                for part in name.split("."):
                    yield getattr(node, "lineno", 0), part


def test_words_are_found():
    for line in ("it told_force = 1", "class NotTold:", "# put in", "def from_afar():", "GRAIN"):
        assert home_made(line), line
    assert not home_made("a constraint is retold in Bentley's grainfield")


def test_home_made_words_stand_nowhere():
    assert len(ALLOWED) <= 20
    found = [
        f"{place}:{number}: {', '.join(words)}: {line.strip()[:80]}"
        for place, number, line, words in hits()
        if not any(place == file and what in line for file, what, _ in ALLOWED)
    ]
    assert not found, "\n".join([f"{len(found)} lines", *found])


def test_no_place_is_allowed_in_vain():
    left = {(file, what) for file, what, _ in ALLOWED if (ROOT / file).suffix in SUFFIXES}
    for place, _, line, _ in hits():
        left -= {(file, what) for file, what in left if file == place and what in line}
    assert not left


def test_renamed_identifiers_stand_nowhere():
    renamed = dict(row.split(" -> ") for row in RENAMED.read_text(encoding="utf-8").splitlines())
    assert len(renamed) > 100
    found = []
    for path in files():
        if path.suffix == ".py" and path != Path(__file__):
            for number, name in used(path.read_text(encoding="utf-8")):
                if name in renamed:
                    place = path.relative_to(ROOT).as_posix()
                    found.append(f"{place}:{number}: {name} is now called {renamed[name]}")
    assert not found, "\n".join(found)
