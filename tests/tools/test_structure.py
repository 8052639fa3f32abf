"""The structure keeps its limits, and the command that says so sees where one is passed."""

import pytest

from tools import structure


@pytest.mark.parametrize("check", structure.CHECKS)
def test_limits_are_kept(check):
    assert check().beyond == []


def test_every_figure_is_printed(capsys):
    structure.main()
    printed = capsys.readouterr().out
    for words in (
        "entries in hannes/",
        "import cycles among",
        "import contract",
        "median",
        "files",
    ):
        assert words in printed


def test_too_many_entries_are_seen(tmp_path):
    for k in range(14):
        (tmp_path / f"part_{k}").mkdir()
    assert structure.entries(tmp_path).beyond
    (tmp_path / "part_0").rename(tmp_path / "bench")
    assert not structure.entries(tmp_path).beyond


def test_circles_are_seen():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}
    assert structure.circles(graph) == [["b", "c"]]
    assert structure.circles({"a": {"b"}, "b": set()}) == []


def test_imports_for_type_checking_count():
    assert "hannes.simulation.simulate" in structure.imports()["hannes"]


@pytest.mark.parametrize(
    "change, why",
    [
        ({"exhaustive": False}, "hannes: no exhaustive contract"),
        ({"layers": ["a : b"]}, "hannes: a : b, whose parts may import each other"),
        ({"containers": ["other"]}, "hannes: no exhaustive contract"),
    ],
)
def test_a_looser_contract_is_seen(change, why):
    whole = {"type": "layers", "exhaustive": True, "layers": ["a | b"]}
    rows = [whole | {"containers": [each]} for each in structure.EXHAUSTIVE]
    assert structure.contract({"contracts": rows}).beyond == []
    rows[0] |= change
    assert structure.contract({"contracts": rows}).beyond[0].startswith(why)
    found = structure.contract({"contracts": rows[1:], "exclude_type_checking_imports": True})
    assert "imports for type checking are not counted" in found.beyond


def test_a_function_is_as_long_as_it_is_written():
    text = (
        "@cached\ndef f():\n    '''Documented.'''\n\n    def g():\n        return 1\n    return g\n"
    )
    assert set(structure.lengths(text)) == {(6, "f"), (2, "g")}
