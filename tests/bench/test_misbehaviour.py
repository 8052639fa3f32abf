"""A virtual board that misbehaves as asked, and what `hannes port` says of such a link."""

import json
import threading

import pytest
from toy_machine import Lag

from hannes.bench.adapters.framed import Framed
from hannes.bench.adapters.text_lines import TextLines
from hannes.bench.board_logic import Settings
from hannes.bench.frames import Frame, encode
from hannes.bench.messages import Kind
from hannes.bench.misbehaviour import Cable, Misbehaviour
from hannes.bench.port_report import examine
from hannes.bench.reader import Link
from hannes.bench.session import session
from hannes.bench.virtual_board import Terminal, VirtualBoard
from hannes.commands.cli import main

PACKETS = [bytes([k % 250 + 1, k // 250 + 1] * 10) + b"\0" for k in range(2000)]


def passed(**how):
    """What comes of a packet a millisecond: the packets, and when each came [s]."""
    cable, found, times = Cable(Misbehaviour(**how)), [], []
    for k in range(2200):
        data = cable.send(PACKETS[k : k + 1], 1e-3 * k)
        fresh = [each + b"\0" for each in data.split(b"\0")[:-1]]
        found, times = found + fresh, times + [1e-3 * k] * len(fresh)
    return found, times


def test_a_sound_cable_changes_nothing():
    assert passed()[0] == PACKETS


@pytest.mark.parametrize("share", [0.01, 0.2])
def test_shares_are_lost_repeated_and_damaged(share):
    near = pytest.approx(2000 * share, rel=0.5)
    assert 2000 - len(passed(lost=share)[0]) == near
    assert len(passed(repeated=share)[0]) - 2000 == near
    whole = set(PACKETS)
    assert sum(each not in whole for each in passed(damaged=share)[0]) == near


def test_packets_come_late_stalled_cut_or_garbled():
    late, times = passed(late=0.05)
    delays = [time - 1e-3 * PACKETS.index(each) for each, time in zip(late, times, strict=True)]
    assert len(late) == 2000 and 0.04 < max(delays) <= 0.051
    _, times = passed(stall=0.5, stall_for=0.1)
    assert not any(0.401 < time % 0.5 < 0.499 for time in times) and len(times) == 2000
    _, times = passed(cut=0.5, cut_for=0.3)
    assert not any(0.5 <= time < 0.8 for time in times) and max(times) > 1.9
    assert max(passed(cut=0.5)[1]) < 0.5
    assert not set(passed(garbled=True)[0]) & set(PACKETS)


def test_a_board_is_reset_on_demand(tmp_path):
    board = VirtualBoard(Lag, Terminal(), Settings(), Misbehaviour(reset=1.0))
    over = threading.Event()
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    with session(Link(board.far.address), tmp_path / "run.rawlog") as talk:
        thread.start()
        try:
            talk.hello()
            assert talk.wait(lambda: talk.heard.restarts == 1, 10.0)
        finally:
            over.set()
            thread.join()
    board.far.close()


@pytest.mark.parametrize("how", [{}, {"lost": 0.05, "damaged": 0.05}], ids=["sound", "worn"])
def test_the_quality_of_a_link_is_printed(how, capsys):
    board = VirtualBoard(Lag, Terminal(), Settings(), Misbehaviour(**how))
    over = threading.Event()
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    thread.start()
    try:
        assert main(["port", board.far.address, "--seconds", "0.6", "--json"]) == 0
    finally:
        over.set()
        thread.join()
        board.far.close()
    said = json.loads(capsys.readouterr().out)
    assert said["rows"] > 300 and 0.0 < said["round_trip"][0] < 0.5
    advice = " ".join(said["advice"])
    assert (said["damaged"] > 5) == bool(how)
    assert ("check baud rate" in advice) == bool(how)
    assert not how or (said["lost"] > 5 and "frames were lost" in advice)


WORN = b"\x05" + 20 * b"x" + b"\0"


class Torn(Terminal):
    """A cable on which six damaged frames come before what the host asks for."""

    worn = 6 * WORN

    def read(self):
        data = super().read()
        if data:
            self.write(self.worn)
            self.worn = b""
        return data


def test_damage_before_the_hello_is_counted_but_for_one_frame():
    """One may have been under way as the port was opened."""
    board = VirtualBoard(Lag, Torn(), Settings(), Misbehaviour())
    over = threading.Event()
    thread = threading.Thread(target=board.run, args=(over.is_set,))
    thread.start()
    try:
        assert examine(Link(board.far.address), 0.1).damaged in (5, 6)
    finally:
        over.set()
        thread.join()
        board.far.close()


def test_what_comes_before_its_layout_is_known_is_no_damage():
    framed, text = Framed(), TextLines()
    sound = encode(Frame(Kind.TELEMETRY, 7, 1000, b"1234"))
    assert framed.feed(sound + WORN, 0.0) == [] and framed.damaged == 1
    assert text.feed(b"1000 0.5\n1000 0.5x\n", 0.0) == [] and text.damaged == 1
