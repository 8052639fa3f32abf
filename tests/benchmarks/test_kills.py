"""A few of the kills of benchmarks/kills, and that what they look for would be seen."""

import json
import os
import subprocess
import sys
import time

import pytest

from benchmarks.kills import __main__ as kills
from benchmarks.kills.fork_server import MARK
from benchmarks.kills.one_kill import SIGNALS, foreseen, run_whole, torn
from benchmarks.kills.processes import ForkServer, fresh, gone, orphans
from benchmarks.kills.verbs import VERBS, prepared
from hannes.core.io.atomic_files import atomic_folder

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")


def test_kills_leave_whole_outputs_and_no_orphan(tmp_path):
    rows = kills.all_kills(("convert",), 6, tmp_path / "kills.jsonl")
    found, bounds = kills.summary(rows)
    assert found[0]["kills"] == 6 and found[0]["reruns"] == 1
    assert found[0]["within writing"] >= 3 and all(each["holds"] for each in bounds[:4])
    assert kills.all_kills(("convert",), 6, tmp_path / "kills.jsonl") == rows  # all on record


def test_a_forked_command_is_in_the_state_of_a_fresh_one(tmp_path):
    verb = VERBS["convert"]
    prepared(tmp_path, [verb.name])
    alone = run_whole(fresh, tmp_path, verb)
    server = ForkServer(alone["modules"])
    forked = run_whole(server.start, tmp_path, verb)
    server.close()
    assert alone["handlers"]["SIGTERM"] == alone["handlers"]["SIGHUP"] == "_interrupt"
    for key in ("handlers", "blocked", "threads", "in the main thread", "calls"):
        assert forked[key] == alone[key]
    assert forked["seconds"] < alone["seconds"]


def test_a_torn_output_is_seen(tmp_path):
    assert torn(tmp_path / "absent") == ""
    with atomic_folder(tmp_path / "out", "run") as folder:
        (folder / "a").write_text("whole")
    assert torn(tmp_path / "out") == ""
    (tmp_path / "out" / "a").write_text("wh")
    assert "not as it was written" in torn(tmp_path / "out")
    (tmp_path / "out" / "a").unlink()
    assert "missing" in torn(tmp_path / "out")
    (tmp_path / "x.h5").write_bytes(b"\x89HDF half")
    assert torn(tmp_path / "x.h5")
    row = {"verb": "run", "number": 0, "moment": 1.0, "torn": "x", "orphans": 1, "rerun": "no"}
    row |= {"signal": "SIGKILL", "fresh": False, "status": 70}
    assert [each["holds"] for each in kills.summary([row])[1]] == [False] * 4 + [True]
    late = kills.summary([row | {"status": 0}])[1][-1]
    assert late["value"] == 1.0 and not late["holds"]
    assert json.dumps(row)


@pytest.mark.parametrize("name", SIGNALS)
def test_an_odd_end_is_seen(name):
    assert foreseen({"signal": name, "status": 0})
    assert foreseen({"signal": name, "status": 130}) == (name != "SIGKILL")
    assert not foreseen({"signal": name, "status": 1})


@pytest.mark.parametrize("of_its_session", [True, False])
def test_an_orphan_is_seen(of_its_session):
    sleeper = subprocess.Popen(
        [sys.executable, "-c", "import time; time.sleep(60)"],
        env={**os.environ, MARK: "" if of_its_session else "me"},
        start_new_session=True,
    )
    leader = sleeper.pid if of_its_session else 2**30  # no process has that number
    try:
        while not orphans(leader, "me"):
            time.sleep(0.01)
        assert orphans(leader, "me") == [sleeper.pid]
    finally:
        sleeper.kill()
        sleeper.wait()
    assert gone(leader, "me")
