"""Limits of reading: what a file is, how far it unpacks, how large a number may be."""

import gzip
import os

import numpy as np
import pytest

from hannes import Recording, load_experiment
from hannes.core.errors import BadInput
from hannes.core.io import bounded
from hannes.core.io.limits import LINE
from hannes.core.io.toml_table import Table, read_text
from hannes.core.recording.matlab import load_mat
from hannes.simulation.experiment import shipped

BALL = shipped.find("soft-ball").read_text(encoding="utf-8")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_what_is_no_regular_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("pipe", "zero"):
        with pytest.raises(BadInput, match="a device, a socket or a named pipe"):
            read_text(tmp_path / name)
    with pytest.raises(BadInput, match="is no name of a file"):
        bounded.require_regular("a\0b")


def test_unpacking_stops_at_the_limit(tmp_path):
    (tmp_path / "zeros.gz").write_bytes(gzip.compress(bytes(20 << 20)))
    blocks = bounded.blocks(tmp_path / "zeros.gz", most=3 << 20)
    assert sum(len(next(blocks)) for _ in range(3)) == 3 << 20
    with pytest.raises(BadInput, match="longer than 3 MiB"):
        next(blocks)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_they_like_across_blocks(tmp_path, monkeypatch, end):
    text = ["time_s,µ_1", *(f"{k},é{k}" for k in range(50)), "", "last"]
    (tmp_path / "t").write_bytes(end.join(text).encode("utf-8-sig"))
    for size in (1, 2, 7):
        monkeypatch.setattr(bounded, "BLOCK", size)
        assert list(bounded.lines(tmp_path / "t")) == text


def test_a_line_is_bounded_and_a_bad_one_has_its_number(tmp_path):
    (tmp_path / "t").write_bytes(b"a\nb\n" + b"c" * (LINE + 2))
    with pytest.raises(BadInput, match="line 3: longer"):
        list(bounded.lines(tmp_path / "t"))
    (tmp_path / "t").write_bytes(b"a\nb\nc\xff\n")
    with pytest.raises(BadInput, match="line 3: not utf-8"):
        list(bounded.lines(tmp_path / "t"))


def test_keys_of_many_parts_are_refused_before_they_are_parsed():
    with pytest.raises(BadInput, match="key of more than 100 parts"):
        Table.parse("a." * 100_000 + "b = 1", "x.toml", ())
    found = Table.parse(f"x = [{', '.join(['0.1'] * 1000)}]", "x.toml", ())
    assert len(found.items("x")) == 1000  # points of numbers are no parts of a key


@pytest.mark.parametrize("number", [1e308, -1.5e300, 2.0**64])
def test_a_number_no_sensor_gives_is_named_with_its_sample(number):
    position = np.linspace(0.0, 1.0, 20)
    position[7] = number
    with pytest.raises(BadInput, match=r'"position" is .* at sample 7, beyond'):
        Recording({"time": np.arange(20.0), "position": position}, {"time": "s", "position": "rad"})


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('points = [["0 s", "0 rad"]', 'points = [["0 s", "1e9 rad"]', r"points\[0\] = 1e\+09 rad"),
        ("[reference]", '[noise]\ncurrent = "1e6 A"\n[reference]', "noise.current = 1e"),
        ('duration = "', 'duration = "9999', "duration = "),
    ],
)
def test_an_absurd_experiment_is_refused_by_name(tmp_path, old, new, said):
    assert old in BALL
    text = BALL.partition("[noise]")[0].replace(old, new, 1)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=said):
        load_experiment(tmp_path / "mine.toml")


@pytest.mark.parametrize("place, byte", [(144, 0xFF), (145, 0x08), (156, 0x77), (176, 0x6E)])
def test_a_damaged_matlab_file_never_reaches_scipy(tmp_path, place, byte):
    from scipy.io import savemat

    path = tmp_path / "m.mat"
    savemat(path, {"time": np.arange(9.0)})
    whole = bytearray(path.read_bytes())
    assert load_mat(path)["time"].size == 9
    whole[place] = byte
    path.write_bytes(whole)
    with pytest.raises(BadInput, match="damaged"):
        load_mat(path)


def test_matlab_structures_cells_and_texts_pass(tmp_path):
    from scipy.io import savemat
    from scipy.sparse import eye

    content = {"s": {"a": 1.0, "b": {"c": "text"}}, "cell": np.array([1.0, "x"], object)}
    content |= {"z": np.array([1j, 2.0]), "sparse": eye(3).tocsc(), "flag": np.array([True])}
    content["empty"] = np.zeros((0, 0))
    for packed in (False, True):
        savemat(tmp_path / "m.mat", content, do_compression=packed)
        assert load_mat(tmp_path / "m.mat")["s"]["b"]["c"] == "text"


def test_every_message_is_one_printable_line():
    assert str(BadInput("a\nb\x1b[31m\u2028c µ")) == "a?b?[31m?c µ"
