"""A few of the kills of benchmarks/kills.py, and that what they look for would be seen."""

import json
import subprocess
import sys

import pytest

from benchmarks import kills
from hannes.core.io.atomic_files import atomic_folder

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")


def test_kills_leave_whole_outputs_and_no_orphan(tmp_path):
    rows = kills.all_kills(("convert",), 6, tmp_path / "kills.jsonl")
    found, bounds = kills.summary(rows)
    assert found[0]["kills"] == 6 and found[0]["reruns"] == 1
    assert found[0]["within writing"] >= 3 and all(each["holds"] for each in bounds)
    assert kills.all_kills(("convert",), 6, tmp_path / "kills.jsonl") == rows  # all on record


def test_a_torn_output_is_seen(tmp_path):
    assert kills.torn(tmp_path / "absent") == ""
    with atomic_folder(tmp_path / "out", "run") as folder:
        (folder / "a").write_text("whole")
    assert kills.torn(tmp_path / "out") == ""
    (tmp_path / "out" / "a").write_text("wh")
    assert "not as it was written" in kills.torn(tmp_path / "out")
    (tmp_path / "out" / "a").unlink()
    assert "missing" in kills.torn(tmp_path / "out")
    (tmp_path / "x.h5").write_bytes(b"\x89HDF half")
    assert kills.torn(tmp_path / "x.h5")
    row = {"verb": "run", "number": 0, "moment": 1.0, "torn": "x", "orphans": 1, "rerun": "no"}
    assert [each["holds"] for each in kills.summary([row])[1]] == [False] * 3
    assert json.dumps(row)


def test_an_orphan_is_seen():
    import os

    sleeper = subprocess.Popen(
        [sys.executable, "-c", "import time; time.sleep(60)"], env={**os.environ, kills.MARK: "me"}
    )
    try:
        assert kills.orphans("me") == [sleeper.pid]
    finally:
        sleeper.kill()
        sleeper.wait()
    assert kills.gone("me")
