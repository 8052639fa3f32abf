"""Frames: what is sent comes back; what was damaged on the way never does."""

import random

import pytest
from toy_machine import Lag

from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import BoardLogic, Settings
from hannes.bench.events import Restarted, Row
from hannes.bench.frames import Frame, Splitter, decode, encode
from hannes.bench.messages import (
    AT_ONCE,
    FROM_BOARD,
    FROM_HOST,
    Alive,
    Answer,
    Ask,
    Channel,
    Hello,
    Kind,
    Points,
    Telemetry,
    lengths,
)
from hannes.bench.sequence import Received

KINDS = {34: 10, 35: 13}


def frames(count: int, seed: int = 1) -> list[Frame]:
    chance = random.Random(seed)
    return [Frame(34, k, 1000 * k, chance.randbytes(10)) for k in range(count)]


def test_a_stream_comes_back_however_it_is_cut():
    sent = frames(50)
    wire = b"".join(map(encode, sent))
    for size in (1, 7, 64, len(wire)):
        splitter = Splitter(KINDS)
        got = [f for k in range(0, len(wire), size) for f in splitter.feed(wire[k : k + size])]
        assert got == sent
        assert splitter.damaged == 0


@pytest.mark.parametrize("length", [0, 9, 11])
def test_a_frame_of_a_wrong_length_is_none(length):
    packet = encode(Frame(34, 1, 2, bytes(length)))[:-1]
    assert decode(packet, KINDS) is None


def test_the_frame_after_a_damaged_one_is_read():
    first, second = map(encode, frames(2))
    broken = bytes([first[0] ^ 1]) + first[1:]
    splitter = Splitter(KINDS)
    assert [f.sequence for f in splitter.feed(broken + second)] == [1]
    assert splitter.damaged == 1


def test_noise_without_end_takes_no_memory():
    splitter = Splitter(KINDS)
    for _ in range(100):
        assert splitter.feed(b"\xff" * 10_000) == []
    assert len(splitter._rest) < 1000
    assert [f.sequence for f in splitter.feed(b"\x00" + encode(frames(1)[0]))] == [0]


def test_every_number_counts_once_and_gaps_are_kept():
    received = Received()
    assert [received.accept(k) for k in (5, 6, 6, 9, 5, 12)] == [
        True,
        True,
        False,
        True,
        False,
        True,
    ]
    assert received.missing == ((7, 9), (10, 12))
    assert [received.accept(k) for k in (8, 8, 10)] == [True, False, True]
    assert received.missing == ((7, 8), (11, 12))


def test_numbers_wrap():
    received = Received()
    assert all(received.accept(k) for k in (2**32 - 1, 0, 1))
    assert received.missing == ()


@pytest.mark.parametrize(
    "message",
    [
        Alive(7),
        Hello(1, "virtual 0.1", 1000, 200_000, 4096, 512, 5),
        Channel(2, "current", "A", "h", 1e-3),
        Points(8, tuple((1000 * k, -k) for k in range(AT_ONCE))),
        Answer(3, 5, 2),
    ],
)
def test_messages_come_back(message):
    packed = message.pack()
    assert len(packed) == lengths(FROM_HOST + FROM_BOARD)[message.KIND]
    assert type(message).unpack(packed) == message


def test_telemetry_is_scaled_and_held_within_its_code():
    layout = Telemetry((Channel(0, "current", "A", "h", 1e-3), Channel(1, "duty", "1", "B", 0.01)))
    assert layout.unpack(layout.pack((-1.234, 0.5))) == pytest.approx((-1.234, 0.5))
    assert layout.unpack(layout.pack((50.0, -1.0))) == pytest.approx((32.767, 0.0))


def test_a_board_that_begins_anew_is_heard_again():
    """Its numbers are low once more: of an old life they would be repeats."""
    listener, events = Framed(), []
    for life in range(2):
        board = BoardLogic(Lag(), Settings())
        asked = [Frame(Kind.ASK, 0, 0, Ask().pack())] if life == 0 else []
        frames = [answer for frame in asked for answer in board.hear(frame)]
        frames += [frame for _ in range(700) for frame in board.tick()]
        again = frames[-50:] if life == 0 else []  # sent once more: the same life
        events.append([e for f in frames + again for e in listener.feed(encode(f), 0.0)])
    assert [type(each) for each in events[0]].count(Restarted) == 0
    assert sum(isinstance(each, Row) for each in events[0]) == 700
    assert [type(each) for each in events[1]].count(Restarted) == 1
    assert sum(isinstance(each, Row) for each in events[1]) > 650
