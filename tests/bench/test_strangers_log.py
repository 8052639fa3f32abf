"""Raw logs and boards that nobody vouches for: odd channels, lost frames, other options."""

import json

import numpy as np
import pytest

from benchmarks.hostile import raw_logs
from hannes.bench import sequence
from hannes.bench.adapters.framed import Framed
from hannes.bench.events import About
from hannes.bench.finish import read_rows, recording
from hannes.bench.frames import Frame, encode
from hannes.bench.messages import VERSION, Channel, Hello, Kind
from hannes.bench.raw_log import RECORD
from hannes.bench.record import recover
from hannes.bench.sequence import Received
from hannes.core.errors import BadInput


def introduced(*channels):
    """What an adapter says of a board that introduces itself so, and how much of it was bad."""
    hello = Hello(VERSION, "odd", 1000, 0, 0, 0, len(channels))
    frames = [Frame(Kind.HELLO, 0, 0, hello.pack())]
    frames += [Frame(Kind.CHANNEL, 1 + k, 0, each.pack()) for k, each in enumerate(channels)]
    board = Framed()
    said = [event for each in frames for event in board.feed(encode(each), 0.0)]
    return said, board.damaged


@pytest.mark.parametrize(
    "odd",
    [
        Channel(1, "current", "A", "s", 1.0),  # a code of Python's struct that is no number
        Channel(1, "current", "A", "", 1.0),
        Channel(1, "current", "A", "h", float("nan")),
        Channel(1, "current", "A", "h", 0.0),
        Channel(1, "a\nb", "A", "h", 1.0),
        Channel(1, "current", "A\n", "h", 1.0),
        Channel(1, "position", "A", "h", 1.0),  # a name twice
    ],
)
def test_a_board_of_odd_channels_is_not_known(odd):
    said, damaged = introduced(Channel(0, "position", "rad", "i", 1e-6), odd)
    assert said == [] and damaged == 1


def test_a_board_of_sound_channels_is_known():
    said, damaged = introduced(Channel(0, "position", "rad", "i", 1e-6))
    assert isinstance(said[0], About) and damaged == 0


def test_the_first_of_very_many_gaps_are_forgotten(monkeypatch):
    monkeypatch.setattr(sequence, "MOST_GAPS", 3)
    received = Received()
    assert all(received.accept(k) for k in range(0, 12, 2))
    assert received.missing == ((5, 6), (7, 8), (9, 10))
    assert [received.accept(k) for k in (1, 7, 7)] == [False, True, False]


def kept(tmp_path, board, packets, options):
    (tmp_path / "a.rawlog").write_bytes(raw_logs.log(board, packets, options))
    return tmp_path / "a.rawlog"


@pytest.mark.parametrize("options", [{"rate": 0}, {"rate": "x"}, {"speed": 1}])
def test_a_log_of_other_options_is_refused(tmp_path, options):
    with pytest.raises(BadInput, match="other options"):
        read_rows(kept(tmp_path, "feetech", [], options))


def test_samples_of_other_channels_within_a_log_are_refused(tmp_path):
    lines = [b"time_us a_1\n1 2\n2 3\n", b"time_us a_1 b_1\n3 4 5\n"]
    with pytest.raises(BadInput, match="1 and of 2 channels"):
        read_rows(kept(tmp_path, "text", lines, {}))
    with pytest.raises(BadInput, match="named 1 channels"):
        read_rows(kept(tmp_path, "text", [b"a_1 a_2 a_1\n1 2 3\n2 3 4\n"], {}))


def test_samples_beyond_what_a_log_can_hold_are_refused(tmp_path, monkeypatch):
    path = kept(tmp_path, "text", [b"a_1\n", b"1\n" * 100], {})
    monkeypatch.setattr("hannes.bench.finish.table_fits", lambda rows, *size: rows < 50)
    with pytest.raises(BadInput, match="50 samples are too many"):
        read_rows(path)


def test_late_frames_are_in_their_place(tmp_path):
    known = raw_logs.frames()
    path = kept(tmp_path, "hannes", [encode(each) for each in [*known[:8], *known[:7:-1]]], {})
    found = recording(read_rows(path))
    assert len(found) == 60 and found.time[0] == 0.0


RANDOM = bytes(np.random.default_rng(1).integers(0, 256, 777, dtype=np.uint8))
HUGE = RECORD.pack(7, 0, 0xF4F4F4F4)  # four gigabytes, it claims


@pytest.mark.parametrize(
    "damage", [RANDOM, HUGE, HUGE + b"x" * 200, bytes(777)], ids=["random", "huge", "on", "zeros"]
)
def test_all_before_a_damage_is_recovered_and_the_rest_is_named(tmp_path, damage):
    sound = raw_logs.of_lines()
    path = tmp_path / "a.rawlog"
    path.write_bytes(sound + damage + RECORD.pack(8, 0, 2) + b"1\n")
    said = []
    made = recover(path, said.append)
    assert len(made) == len(recording(read_rows(_written(tmp_path / "b.rawlog", sound))))
    lost = len(damage) + RECORD.size + 2
    assert said == [
        f"{path}: the log is damaged at byte {len(sound)}: the {lost} bytes from there on are "
        "left out"
    ]
    assert said[0].partition(": ")[2] == json.loads(made.conversion)["left_out"]


def test_a_log_that_is_damaged_at_its_head_is_refused(tmp_path):
    head, _, _ = raw_logs.of_lines().partition(b"\n")
    with pytest.raises(BadInput, match="nothing can be recovered"):
        recover(_written(tmp_path / "a.rawlog", head + b"\n" + RANDOM))


def test_a_log_that_was_cut_off_says_where(tmp_path):
    sound, said = raw_logs.of_lines(), []
    assert len(recover(_written(tmp_path / "a.rawlog", sound), said.append)) > 2 and said == []
    recover(_written(tmp_path / "b.rawlog", sound[:-3]), said.append)
    assert len(said) == 1 and "cut off within a record at byte" in said[0]


def _written(path, data):
    path.write_bytes(data)
    return path
