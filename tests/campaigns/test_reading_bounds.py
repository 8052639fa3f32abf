"""What a stranger's file or mapping could make endless is refused in one line, at once."""

import re

import numpy as np
import pytest

from hannes.campaigns.foreign import parquet_size, skip_pattern
from hannes.campaigns.foreign.mapping_file import read_mapping
from hannes.campaigns.foreign.message_definitions import require_sized
from hannes.campaigns.foreign.parquet_columns import open_parquet
from hannes.core.errors import BadInput
from hannes.core.io.limits import SEARCHED, TOML_BYTES
from hannes.plants.plant_file import load_model

MAPPING = """
[time]
column = "t"
{time}
[channels.position]
column = "x"
unit = "rad"
[text]
{text}
"""


def mapping(folder, time='unit = "s"', text=""):
    path = folder / "m.toml"
    path.write_text(MAPPING.format(time=time, text=text))
    return read_mapping(path)


@pytest.mark.parametrize(
    "pattern, why",
    [
        ("(a+)+$", "repeats a group"),
        ("(a|a)*b", "repeats a group"),
        ("(a){9}", "repeats a group"),
        ("a*a*a*b", "more than 2 repetitions"),
        (r"(a)\1", "refers back"),
        ("(?=a)b", "begins with"),
        ("x{99999999999999999999}", "no regular expression"),
        ("(", "no regular expression"),
    ],
)
def test_a_pattern_that_may_take_for_ever_is_refused(tmp_path, pattern, why):
    with pytest.raises(BadInput, match=why):
        mapping(tmp_path, text=f"skip = '{pattern}'")


@pytest.mark.parametrize(
    "pattern",
    ["^(WARN|boot)", r"^\s*(#|\[)", "Session.*started", r"^[*+?{(]", r"\)\*\+", "(?:a|b)"],
)
def test_usual_patterns_are_taken(tmp_path, pattern):
    assert mapping(tmp_path, text=f"skip = '{pattern}'").text.skip == pattern


def test_a_pattern_is_looked_for_in_the_beginning_of_a_line():
    pattern = skip_pattern.skipper("end$")
    assert skip_pattern.leaves_out(pattern, "the end")
    assert not skip_pattern.leaves_out(pattern, " " * SEARCHED + "the end")
    assert not skip_pattern.leaves_out(skip_pattern.skipper(""), "the end")


def test_a_form_of_stamps_that_python_cannot_use_is_refused(tmp_path):
    with pytest.raises(BadInput, match=r"time.format .* cannot be used: redefinition"):
        mapping(tmp_path, 'format = "%d %d"')


def test_a_long_toml_is_refused_before_it_is_parsed(tmp_path):
    path = tmp_path / "hand.toml"
    path.write_text("a = [" + "1," * (TOML_BYTES // 2) + "]")
    with pytest.raises(BadInput, match="longer than 400000 bytes"):
        load_model(str(path))


def test_a_time_of_a_board_that_no_clock_has_is_refused(tmp_path):
    from hannes.bench.board_file import read_board

    path = tmp_path / "board.toml"
    for text in ('[board]\nwatchdog = "1e300 s"', '[misbehaviour]\nstall = "1e30 s"'):
        path.write_text(f'experiment = "void-closure"\n{text}\n')
        with pytest.raises(BadInput, match=r"expected .*1e\+06 s"):
            read_board(path)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('watchdog = "-5 ms"', "board.watchdog = -0.005 s: expected more than zero"),
        ('current_limit = "0 A"', "board.current_limit = 0 A: expected more than zero"),
    ],
)
def test_a_limit_of_a_board_that_is_none_is_named_with_its_value(tmp_path, line, said):
    from hannes.bench.board_file import read_board

    path = tmp_path / "board.toml"
    path.write_text(f'experiment = "void-closure"\n[board]\n{line}\n')
    with pytest.raises(BadInput) as refused:
        read_board(path)
    assert str(refused.value) == f"{path}: {said}"


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_pages_of_parquet_count_as_their_heads_state(tmp_path, monkeypatch, version):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "x.parquet"
    made = pyarrow.table({"a": np.arange(1e5), "name": ["x"] * 10**5})
    parquet.write_table(made, path, compression="zstd", data_page_version=version)
    parquet_size.require_unpackable(path)
    assert open_parquet(path, ()).names == ("a",)
    monkeypatch.setattr(parquet_size, "BYTES", 10**5 // 8)
    with pytest.raises(BadInput, match="unpacks to more than"):
        parquet_size.require_unpackable(path)


def test_messages_of_no_bytes_in_lists_are_refused():
    kinds = pytest.importorskip("rosbags.interfaces").Nodetype
    nothing, list_of = ("x/msg/Nothing", ([], [])), (kinds.NAME, "x/msg/Nothing")
    require_sized(dict([nothing, ("x/msg/One", ([], [("a", list_of)]))]), "log")
    listed = (kinds.SEQUENCE, (list_of, 0))
    with pytest.raises(BadInput, match="too many elements"):
        require_sized(dict([nothing, ("x/msg/Many", ([], [("a", listed)]))]), "log")


def test_the_words_that_name_limits_stand_on_their_page():
    from pathlib import Path

    page = Path(__file__).parents[2] / "docs" / "reference" / "limits.md"
    for name in ("SEARCHED", "REPEATS", "TOML_BYTES"):
        assert re.search(rf"\| `{name}` \|", page.read_text(encoding="utf-8"))
