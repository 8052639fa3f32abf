"""JSON that anybody may have written: marks, raw logs, what a recording says of itself."""

import gzip
import json
from dataclasses import replace

import numpy as np
import pytest

from hannes import Recording
from hannes.bench.finish import read_rows
from hannes.campaigns.check import check
from hannes.campaigns.quality.conversion import conversion
from hannes.core.errors import BadInput
from hannes.core.io import result_marks
from hannes.core.io.json_text import parsed, table
from hannes.plants.protocol import shipped_plant

DEEP = "[" * 100_000


def test_what_is_nested_too_deep_is_no_json(tmp_path):
    with pytest.raises(ValueError, match="too deep"):
        parsed(DEEP)
    assert table(DEEP) == table("[1]") == {} and table('{"a": 1}') == {"a": 1}
    (tmp_path / "a.rawlog").write_text(DEEP + "\n")
    with pytest.raises(BadInput, match="no raw log"):
        read_rows(tmp_path / "a.rawlog")
    (tmp_path / result_marks.MARKER).write_text(DEEP)
    assert result_marks.folder_mark(tmp_path) is None
    (tmp_path / "a.csv.hannes.json").write_text(DEEP)
    assert result_marks.file_verb(tmp_path / "a.csv.hannes.json") is None


def test_a_verb_that_a_mark_names_is_one_word(tmp_path):
    (tmp_path / result_marks.MARKER).write_text(json.dumps({"verb": "a\nb", "files": {}}))
    assert result_marks.folder_mark(tmp_path).verb == ""
    (tmp_path / "a.csv.hannes.json").write_text('{"verb": "run\\n", "sha256": []}')
    assert result_marks.file_verb(tmp_path / "a.csv.hannes.json") is None


def test_rows_of_a_former_result_are_counted_within_limits(tmp_path, monkeypatch):
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(b"t_s\n1\n2"))
    beside = tmp_path / "a.csv.gz.conversion.json"
    beside.write_text('{"samples": 2, "channels": {}}')
    assert result_marks.file_verb(tmp_path / "a.csv.gz") == "convert"
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(b"\n" * 10**6)[:-20])
    for samples in (-1, 10**6):
        beside.write_text(json.dumps({"samples": samples, "channels": {}}))
        assert result_marks.file_verb(tmp_path / "a.csv.gz") is None


@pytest.mark.parametrize(
    "said",
    [
        DEEP,
        '{"cut_s": 5, "channels": []}',
        '{"cut_s": [[1], ["a", 2], null, [0, 1e999]], "channels": {"position": 3}}',
        '{"channels": {"position": {"factor": 1e-320}, "current": {"factor": "x", "offset": []}}}',
        '{"channels": {"position": {"column": "a\\nb"}, "current": {"column": true}}}',
    ],
)
def test_what_a_recording_says_of_its_conversion_is_not_believed(said):
    found = conversion(said)
    assert found.columns == {} and found.cuts == ()
    assert set(found.scales.values()) <= {(1.0, 0.0)}
    time = 0.01 * np.arange(100)
    moved = {"position": np.where(time > 0.5, 65530.0, 0.1), "current": np.full(100, -999.0)}
    moved["current"][:90] = time[:90]
    units = {"time": "s", "position": "rad", "current": "A"}
    made = Recording({"time": time, **moved}, units)
    expected = check(made, shipped_plant("hand"))
    assert check(replace(made, conversion=said), shipped_plant("hand")) == expected


def test_a_conversion_is_known():
    rule = {"column": 3, "factor": 2.0, "offset": 1.0}
    said = {"cut_s": [[0.5, 0.7]], "channels": {"a": rule, "b": {"column": "x"}}}
    found = conversion(json.dumps(said))
    assert found.columns == {"a": "3", "b": "x"} and found.cuts == ((0.5, 0.7),)
    assert found.scales == {"a": (2.0, 1.0), "b": (1.0, 0.0)}
