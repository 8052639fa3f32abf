"""No command destroys what it was given, nor what hannes did not write."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hannes.commands.cli import main
from hannes.core.errors import BadInput
from hannes.core.io import outputs, result_marks
from hannes.core.io.atomic_files import atomic_folder
from hannes.core.io.result_marks import MARKER, file_verb, folder_mark
from hannes.core.recording.recording import Recording

RAMP = '[reference]\nkind = "ramp"\npoints = [["0 s", "0 rad"], ["1 s", "15 rad"]]\n'
SHORT = 'duration = "20 ms"\n' + RAMP
MAPPING = """
[time]
column = "t"
unit = "s"
[channels.current]
column = "i"
unit = "A"
[channels.reference]
column = "r"
unit = "rad"
"""
# Arguments of each verb without its output, what of them it reads, whether it writes a folder.
VERBS = {
    "run": (["run", "in/short.toml"], ["in/short.toml"], True),
    "calibrate": (["calibrate", "in/campaign.toml"], ["in/campaign.toml", "in/r.csv"], True),
    "diagnose": (["diagnose", "in/campaign.toml"], ["in/campaign.toml", "in/r.csv"], True),
    "compare": (["compare", "in/campaign.toml"], ["in/campaign.toml", "in/r.csv"], True),
    "reproduce": (["reproduce", "--slack", "in/slack"], ["in/slack"], True),
    "evaluate": (["evaluate", "in/model.h5", "in/e.toml"], ["in/model.h5", "in/e.toml"], True),
    "convert": (["convert", "in/log.csv", "--mapping", "in/map.toml"], ["in/log.csv"], False),
    "dataset": (["dataset", "in/set.toml"], ["in/set.toml"], False),
    "grasp": (["dataset", "in/set.toml", "--grasp", "0"], ["in/set.toml"], False),
    "train": (["train", "in/data.h5"], ["in/data.h5"], False),
    "export": (["export", "in/r.h5"], ["in/r.h5"], False),
    "view": (["view", "in/r.h5"], ["in/r.h5"], False),
}
SUFFIX = {"view": ".html"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Inputs of all verbs, some of them no more than their names; foreign files beside them."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    for name, text in {
        "short.toml": SHORT,
        "set.toml": SHORT + '[[grasps]]\nshape = "none"\n',
        "campaign.toml": 'out = "results"\n[[recording]]\nfile = "r.csv"\n',
        "map.toml": MAPPING,
        "log.csv": "t,i,r\n0,1,0\n0.1,2,0\n0.2,3,0\n",
        "e.toml": '[[object]]\nclass = "soft"\nfile = "r.h5"\n',
    }.items():
        (tmp_path / "in" / name).write_text(text)
    times = np.arange(0.0, 0.1, 1e-3)
    channels = {"time": times, "current": np.sin(times), "reference": times}
    recording = Recording(channels, {"time": "s", "current": "A", "reference": "rad"})
    recording.write(tmp_path / "in" / "r.csv")
    recording.write(tmp_path / "in" / "r.h5")
    for name in ("model.h5", "data.h5"):
        shutil.copy(tmp_path / "in" / "r.h5", tmp_path / "in" / name)
    (tmp_path / "in" / "slack").mkdir()
    (tmp_path / "in" / "slack" / "verdict.json").write_text("{}")
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "thesis.txt").write_text("precious")
    for suffix in (".csv", ".h5", ".html", ".txt"):
        (tmp_path / f"foreign{suffix}").write_bytes(b"\x89HDF precious" + suffix.encode())
    return tmp_path


def tree(folder):
    """Every file below a folder with its digest; links by their target."""
    return {
        str(each): os.readlink(each)
        if each.is_symlink()
        else hashlib.sha256(each.read_bytes()).hexdigest()
        for each in sorted(folder.rglob("*"))
        if each.is_file() or each.is_symlink()
    }


def targets(verb):
    """Outputs that must not be taken: inputs, their folders, links to them, what is foreign."""
    _, inputs, writes_folder = VERBS[verb]
    named = [*inputs, "in", "notes", ".", "/dev/null", "foreign.csv", "foreign.txt", "foreign.h5"]
    named += ["foreign.h5/below", "x" * 250 + SUFFIX.get(verb, ".h5"), "nul\0.h5", "foreign.html"]
    links = [f"link-{k}{Path(each).suffix}" for k, each in enumerate(inputs)]
    return named, dict(zip(links, inputs, strict=True)), writes_folder


CASES = [(verb, name) for verb in VERBS for name in [*targets(verb)[0], *targets(verb)[1]]]


@pytest.mark.parametrize(("verb", "name"), CASES)
@pytest.mark.parametrize("force", [False, True])
def test_what_is_read_or_foreign_stays(folder, capsys, verb, name, force):
    arguments, _, _ = VERBS[verb]
    for link, target in targets(verb)[1].items():
        os.symlink(target, link)
    before = tree(folder)
    status = main([*arguments, "--out", name, *["--force"] * force])
    printed = capsys.readouterr().err
    harmless = verb == "convert" and name in ("in", "notes", ".")  # new files beside the others
    after = tree(folder)
    assert {each: after.get(each) for each in before} == before
    if not harmless:
        assert status == 2 and printed.count("\n") == 1 and after == before, printed


@pytest.mark.parametrize("verb", ["run", "convert", "export", "grasp"])
def test_a_former_result_gives_way_and_one_of_another_verb_does_not(folder, capsys, verb):
    arguments, _, is_folder = VERBS[verb]
    out = "out" if is_folder else "out.csv" if verb != "grasp" else "out.h5"
    for _ in range(2):
        assert main([*arguments, "--out", out]) == 0
    other = "export" if verb == "convert" else "convert"
    if is_folder:
        with pytest.raises(BadInput, match="hannes run"), atomic_folder(out, other):
            pass
        with atomic_folder(out, other, force=True) as temporary:
            (temporary / "a").write_text("x")
    else:
        again = VERBS[other][0]
        assert main([*again, "--out", out]) == 2
        assert "--force" in capsys.readouterr().err
        assert main([*again, "--out", out, "--force"]) == 0
        assert file_verb(Path(out)) == other


def test_files_among_results_are_kept_and_never_replaced(folder):
    with atomic_folder("out", "run") as temporary:
        (temporary / "deep").mkdir()
        (temporary / "deep" / "a").write_text("1")
    Path("out/deep/mine").write_text("mine")
    with atomic_folder("out", "run") as temporary:
        (temporary / "b").write_text("2")
    assert Path("out/deep/mine").read_text() == "mine" and not Path("out/deep/a").exists()
    Path("out/c").write_text("mine")
    with pytest.raises(BadInput, match="c in it was not written by hannes"):
        with atomic_folder("out", "run") as temporary:
            (temporary / "c").write_text("3")
    assert Path("out/c").read_text() == "mine" and Path("out/b").read_text() == "2"
    Path("out/b").write_text("edited")
    with pytest.raises(BadInput, match="b in it was changed"), atomic_folder("out", "run"):
        pass
    assert Path("out/b").read_text() == "edited"


@pytest.mark.parametrize(
    ("file", "verb"), [*result_marks.FILES_OF_FORMER_VERBS.items(), ("anything", None)]
)
def test_folders_of_earlier_versions_are_known(tmp_path, file, verb):
    (tmp_path / file).write_text("x")
    (tmp_path / MARKER).write_text(json.dumps([file]) + "\n")
    mark = folder_mark(tmp_path)
    assert mark is not None and mark.verb == verb and mark.lists(file)
    with atomic_folder(tmp_path, verb or "run") as temporary:
        (temporary / file).write_text("y")
    assert (tmp_path / file).read_text() == "y"


def test_converted_csv_of_an_earlier_version_is_known(folder):
    assert main([*VERBS["convert"][0], "--out", "out.csv"]) == 0
    beside = Path("out.csv.conversion.json")
    content = json.loads(beside.read_text())
    beside.write_text(json.dumps({k: v for k, v in content.items() if k not in ("verb", "sha256")}))
    assert file_verb(Path("out.csv")) == "convert"
    assert main([*VERBS["convert"][0], "--out", "out.csv"]) == 0
    Path("out.csv").write_text(Path("out.csv").read_text() + "9,9,9\n")
    assert file_verb(Path("out.csv")) is None


def test_a_results_folder_whose_recordings_are_diagnosed_is_not_replaced(folder, capsys):
    assert main(["run", "in/short.toml", "--out", "made"]) == 0
    Path("c.toml").write_text('[[recording]]\nfile = "made/recording.h5"\n')
    before = tree(Path("made"))
    for verb in ("diagnose", "calibrate"):
        assert main([verb, "c.toml", "--out", "made", "--force"]) == 2
        assert "is read here" in capsys.readouterr().err
    assert tree(Path("made")) == before


HOLD = """
import sys, time
from hannes.core.io.outputs import reserved
with reserved("run", [sys.argv[1]], folder=True):
    print("held", flush=True)
    time.sleep(60)
"""


def test_of_two_commands_on_one_output_the_second_is_refused(folder, capsys):
    first = subprocess.Popen([sys.executable, "-c", HOLD, "out"], stdout=subprocess.PIPE)
    try:
        assert first.stdout is not None and first.stdout.readline() == b"held\n"
        assert main(["run", "in/short.toml", "--out", "out"]) == 2
        assert "another command is writing out" in capsys.readouterr().err
    finally:
        first.kill()
        first.wait()
        first.stdout.close()
    assert main(["run", "in/short.toml", "--out", "out"]) == 0  # a dead one holds nothing


def test_a_new_name_below_a_folder_that_is_read_is_harmless(tmp_path):
    (tmp_path / "read").mkdir()
    (tmp_path / "read" / "verdict.json").write_text("{}")
    below = tmp_path / "read" / "out"
    outputs.require_free("reproduce", below, [tmp_path / "read"], folder=True)
    for taken in (tmp_path / "read", tmp_path):
        with pytest.raises(BadInput, match="is read here"):
            outputs.require_free("reproduce", taken, [tmp_path / "read"], folder=True)
