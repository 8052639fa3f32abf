"""Results are old or new, never half; nothing that hannes did not write is replaced."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.atomic_files import (
    atomic_file,
    atomic_folder,
    settled,
    write_bytes,
    write_text,
)
from hannes.core.io.result_marks import MARKER


def tree(folder: Path) -> dict[str, str]:
    return {
        str(each.relative_to(folder)): each.read_text()
        for each in sorted(folder.rglob("*"))
        if each.is_file() and each.name != MARKER
    }


def write_results(folder: Path, **contents: str) -> None:
    with atomic_folder(folder) as temporary:
        for name, content in contents.items():
            (temporary / name).write_text(content)


def test_writes_text_and_bytes_into_new_folders(tmp_path: Path) -> None:
    write_text(tmp_path / "a" / "b.txt", "1\n2\r\n\u00b5")
    assert (tmp_path / "a" / "b.txt").read_bytes() == b"1\n2\r\n\xc2\xb5"
    write_bytes(tmp_path / "a" / "b.txt", b"\0")
    assert (tmp_path / "a" / "b.txt").read_bytes() == b"\0"
    assert os.listdir(tmp_path / "a") == ["b.txt"]


def test_temporary_name_keeps_the_suffix_and_the_usual_mode(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    with atomic_file(tmp_path / "figure.svg") as temporary:
        assert temporary.suffix == ".svg" and temporary.parent == tmp_path
        temporary.write_text("x")
    assert (tmp_path / "figure.svg").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("fault", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_exception_leaves_the_old_and_nothing_else(
    tmp_path: Path, fault: type[BaseException]
) -> None:
    write_text(tmp_path / "f", "old")
    write_results(tmp_path / "d", a="old")
    with pytest.raises(fault), atomic_file(tmp_path / "f") as temporary:
        temporary.write_text("half")
        raise fault
    with pytest.raises(fault), atomic_folder(tmp_path / "d") as temporary:
        (temporary / "a").write_text("half")
        raise fault
    assert tree(tmp_path) == {"f": "old", "d/a": "old"}
    assert sorted(os.listdir(tmp_path)) == ["d", "f"]


@pytest.mark.parametrize("exchange", [True, False])
def test_folder_is_replaced_as_a_whole_and_keeps_what_is_not_ours(
    tmp_path: Path, exchange: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not exchange:
        monkeypatch.setattr(atomic_files, "_exchange", lambda one, other: False)
    target = tmp_path / "results" / "closure"
    write_results(target, a="1", b="1")
    (target / "notes.txt").write_text("mine")
    (target / "deep").mkdir()
    (target / "deep" / "c").write_text("mine too")
    for _ in range(2):
        write_results(target, a="2")
        assert tree(target) == {"a": "2", "notes.txt": "mine", "deep/c": "mine too"}
    assert os.listdir(target.parent) == ["closure"]


def test_a_foreign_folder_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "recording.csv").write_text("precious")
    with pytest.raises(BadInput, match="not earlier results"):
        write_results(tmp_path, a="1")
    assert tree(tmp_path) == {"recording.csv": "precious"}
    (tmp_path / "empty").mkdir()
    write_results(tmp_path / "empty", a="1")
    assert tree(tmp_path / "empty") == {"a": "1"}


KILLED = """
import os, signal, sys
from hannes.core.io import atomic_files
stage, folder = sys.argv[1:]
def die(*_): os.kill(os.getpid(), signal.SIGKILL)
if stage == "between":
    atomic_files._exchange = lambda one, other: False
    rename = os.rename
    os.rename = lambda a, b: (rename(a, b), die())
if stage == "after":
    exchange = atomic_files._exchange
    atomic_files._exchange = lambda a, b: (exchange(a, b), die())
with atomic_files.atomic_folder(folder) as temporary:
    (temporary / "a").write_text("new")
    if stage == "body": die()
    (temporary / "b").write_text("new")
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
@pytest.mark.parametrize("stage", ["body", "between", "after"])
def test_killed_command_leaves_old_or_new(tmp_path: Path, stage: str) -> None:
    target = tmp_path / "d"
    write_results(target, a="old", b="old")
    done = subprocess.run([sys.executable, "-c", KILLED, stage, str(target)], check=False)
    assert done.returncode < 0
    assert tree(settled(target)) in ({"a": "old", "b": "old"}, {"a": "new", "b": "new"})
    write_results(target, a="next")
    assert tree(target) == {"a": "next"}


def test_failed_second_rename_puts_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_results(tmp_path / "d", a="old")
    rename = os.rename

    def refuse(one: Path, other: Path) -> None:
        if ".tmp-" in str(one):
            raise OSError(errno.EIO, "input/output error")
        rename(one, other)

    monkeypatch.setattr(atomic_files, "_exchange", lambda one, other: False)
    monkeypatch.setattr(os, "rename", refuse)
    with pytest.raises(BadInput, match="input/output error"):
        write_results(tmp_path / "d", a="new")
    assert tree(tmp_path) == {"d/a": "old"}


def test_leftovers_are_swept_after_a_week(tmp_path: Path) -> None:
    old, young, other = (tmp_path / f".tmp-{n}" for n in ("1.f", "2.f", "3.g"))
    for each in (old, young, other):
        each.write_text("")
    for each in (old, other):
        os.utime(each, (0, 0))
    write_text(tmp_path / "f", "x")
    assert not old.exists() and young.exists() and other.exists()


def test_says_why_a_target_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for target in (tmp_path / "file" / "x", tmp_path, tmp_path / ("n" * 300), "a\0b", os.devnull):
        with pytest.raises(BadInput, match="cannot write") as caught:
            write_text(target, "x")
        assert "\n" not in str(caught.value)
    for folder in (tmp_path / "file" / "x", tmp_path / "file"):
        with pytest.raises(BadInput, match="is a file"):
            write_results(folder, a="1")
    assert tree(tmp_path) == {"file": ""}


@pytest.mark.parametrize(
    ("number", "words"),
    [(errno.EACCES, "permission denied"), (errno.ENOSPC, "no space left"), (errno.EROFS, "read-")],
)
def test_system_faults_become_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, words: str
) -> None:
    def fail(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(BadInput, match=words):
        write_text(tmp_path / "f", "x")
    assert os.listdir(tmp_path) == []


def test_full_disk_while_writing_is_explained_and_other_faults_are_not_ours(
    tmp_path: Path,
) -> None:
    with pytest.raises(BadInput, match="no space left"), atomic_file(tmp_path / "f"):
        raise OSError(errno.ENOSPC, "full")
    with pytest.raises(FileNotFoundError), atomic_file(tmp_path / "f"):
        raise FileNotFoundError("some input")
    assert os.listdir(tmp_path) == []
