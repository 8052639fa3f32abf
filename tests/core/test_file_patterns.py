"""Which files a pattern means, and in which order."""

import pytest

from hannes.core.errors import BadInput
from hannes.core.io.file_patterns import matching


def test_numbers_inside_names_are_in_order(tmp_path):
    for name in ("void_10.csv", "void_2.csv", "a_3.csv", "void_2b.csv"):
        (tmp_path / name).touch()
    (tmp_path / "void_02.csv").touch()
    names = ["a_3.csv", "void_02.csv", "void_2.csv", "void_2b.csv", "void_10.csv"]
    assert [each.name for each in matching("*.csv", tmp_path)] == names


def test_a_pattern_may_be_absolute(tmp_path):
    (tmp_path / "one.h5").touch()
    assert matching(str(tmp_path / "*.h5"), tmp_path / "elsewhere") == [tmp_path / "one.h5"]


@pytest.mark.parametrize("pattern", ["**.csv", "a**/b.csv", ""])
def test_what_is_no_pattern_is_said(tmp_path, pattern):
    with pytest.raises(BadInput, match="no pattern of files"):
        matching(pattern, tmp_path)


@pytest.mark.parametrize("pattern", [".", "./", "a" * 300 + "*", "a\0*"])
def test_what_names_no_file_is_one_line(tmp_path, pattern):
    try:
        assert matching(pattern, tmp_path) == []
    except BadInput as error:
        assert "no pattern of files" in str(error)
