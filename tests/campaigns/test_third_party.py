"""Recordings of other laboratories: given by the user, fetched and checked, or plainly missing."""

import gzip
import hashlib
import os
import threading
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from hannes.campaigns import third_party
from hannes.core.errors import BadInput, MissingRecording

GIVEN = os.environ.get("HANNES_MEASURED")
CONTENT = {"one.mat": b"first recording", "two.mat": b"second recording"}


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format, *args):
        self.server.asked.append(self.path)


@pytest.fixture(autouse=True)
def machine(tmp_path, monkeypatch):
    """A user with an empty cache, no HANNES_MEASURED, and a set `demo` of two small files."""
    monkeypatch.delenv("HANNES_MEASURED", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    monkeypatch.setattr("pooch.os_cache", lambda project: tmp_path / "cache" / project)
    sums = {name: hashlib.sha256(content).hexdigest() for name, content in CONTENT.items()}
    demo = replace(third_party.SOURCES["emps"], sha256=sums)
    monkeypatch.setitem(third_party.SOURCES, "demo", demo)


def write(where: Path) -> Path:
    where.mkdir(parents=True)
    for name, content in CONTENT.items():
        (where / name).write_bytes(content)
    return where


@pytest.fixture
def served(tmp_path):
    return write(tmp_path / "served")


@pytest.fixture
def server(served):
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(served))) as server:
        server.asked = []
        server.url = f"http://127.0.0.1:{server.server_port}/"
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        yield server
        server.shutdown()


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in CONTENT}


def test_fetches_every_file_once(server):
    assert contents(third_party.folder("demo", server.url)) == CONTENT
    third_party.folder("demo", server.url)
    assert sorted(server.asked) == ["/one.mat", "/two.mat"]


def test_cached_set_needs_no_network(server):
    third_party.folder("demo", server.url)
    assert contents(third_party.folder("demo", "http://127.0.0.1:1/")) == CONTENT


def test_corrupted_cache_is_fetched_again(server):
    folder = third_party.folder("demo", server.url)
    (folder / "two.mat").write_bytes(b"second rec")
    assert contents(third_party.folder("demo", server.url)) == CONTENT


def test_wrong_checksum_is_refused_and_not_kept(server, served, tmp_path):
    (served / "two.mat").write_bytes(b"something else")
    with pytest.raises(MissingRecording, match="SHA-256 differs"):
        third_party.folder("demo", server.url)
    assert not (tmp_path / "cache/hannes/demo/two.mat").exists()


def test_absent_server_is_one_line_that_says_what_to_do():
    with pytest.raises(MissingRecording) as caught:
        third_party.folder("demo", "http://127.0.0.1:1/")
    text = str(caught.value)
    assert "\n" not in text
    assert all(part in text for part in ("one.mat", "HANNES_MEASURED is not set", "no answer"))
    assert caught.value.exit_status == 2


def test_file_gone_from_the_server(server, served):
    (served / "one.mat").unlink()
    with pytest.raises(MissingRecording, match="the server answered 404"):
        third_party.folder("demo", server.url)


def test_silent_server_is_given_up(monkeypatch):
    import socket

    monkeypatch.setattr(third_party, "SECONDS_TO_ANSWER", 0.1)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        with pytest.raises(MissingRecording, match="no answer"):
            third_party.folder("demo", f"http://127.0.0.1:{silent.getsockname()[1]}/")


def test_cache_that_cannot_be_written(server, tmp_path):
    (tmp_path / "cache").write_text("a file where a folder should be")
    with pytest.raises(MissingRecording) as caught:
        third_party.folder("demo", server.url)
    assert "\n" not in str(caught.value)


def test_given_folder_is_used_as_it_is(tmp_path, monkeypatch):
    write(tmp_path / "mine/demo")
    monkeypatch.setenv("HANNES_MEASURED", str(tmp_path / "mine"))
    assert third_party.folder("demo", "http://127.0.0.1:1/") == tmp_path / "mine/demo"


def test_given_folder_that_lacks_a_file_falls_back_to_fetching(tmp_path, monkeypatch, server):
    write(tmp_path / "mine/demo")
    (tmp_path / "mine/demo/one.mat").unlink()
    monkeypatch.setenv("HANNES_MEASURED", str(tmp_path / "mine"))
    assert contents(third_party.folder("demo", server.url)) == CONTENT
    with pytest.raises(MissingRecording, match="lacks them"):
        (tmp_path / "cache/hannes/demo/one.mat").unlink()
        third_party.folder("demo", "http://127.0.0.1:1/")


def test_given_files_may_be_packed(tmp_path, monkeypatch):
    write(tmp_path / "mine/demo")
    for name in CONTENT:
        (tmp_path / f"mine/demo/{name}").rename(tmp_path / f"mine/demo/{name}.gz")
    monkeypatch.setenv("HANNES_MEASURED", str(tmp_path / "mine"))
    assert third_party.folder("demo", "http://127.0.0.1:1/") == tmp_path / "mine/demo"


def test_a_file_that_was_moved_is_fetched_from_where_it_is(server, served, monkeypatch):
    (served / "more").mkdir()
    (served / "two.mat").rename(served / "more/two.mat")
    moved = replace(third_party.SOURCES["demo"], moved={"two.mat": "more/"})
    monkeypatch.setitem(third_party.SOURCES, "demo", moved)
    assert contents(third_party.folder("demo", server.url)) == CONTENT
    assert sorted(server.asked) == ["/more/two.mat", "/one.mat"]


def test_many_missing_files_are_still_one_line(monkeypatch):
    with pytest.raises(MissingRecording) as caught:
        third_party.folder("rh56_finger", "http://127.0.0.1:1/")
    text = str(caught.value)
    assert len(text) < 700 and "..." in text and third_party.SOURCES["rh56_finger"].commit in text


def test_unknown_set_shows_the_nearest():
    with pytest.raises(BadInput, match='did you mean "emps"'):
        third_party.folder("emsp")


def test_sources_are_pinned():
    for name in ("emps", "rh56_finger"):
        source = third_party.SOURCES[name]
        assert len(source.commit) == 40
        assert source.commit in source.url and source.commit in source.page
        assert all(len(digest) == 64 for digest in source.sha256.values())
        assert set(source.moved) <= set(source.sha256)


def test_given_recordings_of_the_finger_are_those_that_were_published(monkeypatch):
    root = Path(GIVEN or "nowhere")
    if not (root / "rh56_finger").is_dir():
        pytest.skip("needs HANNES_MEASURED with the recordings rh56_finger")
    for name, digest in third_party.SOURCES["rh56_finger"].sha256.items():
        packed = root / "rh56_finger" / f"{name}.gz"
        data = gzip.decompress(packed.read_bytes()) if packed.exists() else None
        data = data or (root / "rh56_finger" / name).read_bytes()
        assert hashlib.sha256(data).hexdigest() == digest
