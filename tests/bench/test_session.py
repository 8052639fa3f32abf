"""Through a pseudo-terminal: a hello, a profile, a recording; a port that is busy, silent, gone."""

import json
import os
import threading
import time

import numpy as np
import pytest
from toy_machine import Lag

from hannes.bench.board_logic import BoardLogic, Settings
from hannes.bench.finish import read_rows, recording
from hannes.bench.messages import State
from hannes.bench.misbehaviour import Cable, Misbehaviour
from hannes.bench.port import Port
from hannes.bench.reader import Link
from hannes.bench.record import recover
from hannes.bench.session import session
from hannes.bench.virtual_board import Socket, Terminal, VirtualBoard
from hannes.commands.cli import main
from hannes.core.errors import BadInput, ComputationFailed, Interrupted
from hannes.core.recording.recording import Recording

RAMP = [(0.0, 0.0), (0.1, 1.0), (0.2, 0.0)]


class Running:
    """A virtual board in a thread."""

    def __init__(self, far, how=None, **settings) -> None:
        self.board = VirtualBoard(Lag, far, Settings(**settings), how or Misbehaviour())
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.board.run, args=(self.over.is_set,))

    def __enter__(self):
        self.thread.start()
        return self.board

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()
        self.board.far.close()


@pytest.mark.parametrize("far", [Terminal, lambda: Socket(0)], ids=["terminal", "socket"])
def test_a_profile_becomes_a_recording(tmp_path, far):
    log = tmp_path / "run.rawlog"
    with Running(far()) as board, session(Link(board.far.address), log) as talk:
        assert talk.hello().rate == 1000.0
        latency, priority = talk.reader.notes  # what could be had is said
        assert latency.startswith("low latency: ") and priority.startswith("priority: ")
        talk.profile(RAMP)
        talk.run_to_end(0.2)
    assert board.logic.state.name in ("STOPPED", "IDLE")
    rows = read_rows(log)
    made = recording(rows, duration=0.2)
    assert made.time[0] == pytest.approx(0.0, abs=2e-3)
    assert made["reference"].max() == pytest.approx(1.0, abs=0.02)
    said = json.loads(made.conversion)
    lost = sum(round((b - a) * 1000) - 1 for a, b in said["gaps_s"])
    assert made.time.size + lost == pytest.approx(201, abs=2)


def test_a_log_that_was_cut_off_gives_all_before(tmp_path):
    log = tmp_path / "run.rawlog"
    with Running(Terminal()) as board, session(Link(board.far.address), log) as talk:
        talk.hello()
        talk.wait(lambda: False, 0.2)
    whole = read_rows(log)
    (tmp_path / "cut.rawlog").write_bytes(log.read_bytes()[:-150])  # more than a pulse at its end
    cut = read_rows(tmp_path / "cut.rawlog")
    assert 0 < whole.board.size - cut.board.size <= 30
    assert np.array_equal(whole.values[: cut.board.size], cut.values)


def refusal(port, tmp_path, **link):
    with pytest.raises(BadInput) as refused:
        with session(Link(port, **link), tmp_path / f"{time.monotonic_ns()}.rawlog") as talk:
            talk.hello()
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_a_port_that_is_absent(tmp_path):
    assert "no such port" in refusal("/dev/no-such-port", tmp_path)


@pytest.mark.parametrize("port", ["99999", "-1", "abc", "", "1x"])
def test_a_port_number_that_is_none(capsys, port):
    for kind in ("socket", "rfc2217"):
        with pytest.raises(BadInput, match=f"expected {kind}://HOST:PORT, with a port from 0 to"):
            Port(f"{kind}://127.0.0.1:{port}")
    for verb, option in (("board", "--tcp"), ("panel", "--http")):
        assert main([verb, "x", f"{option}={port}"]) == 2
        said = capsys.readouterr().err
        assert f"argument {option}: expected a port from 0 to 65535" in said
        assert said.count("\n") == 1
    with pytest.raises(BadInput, match="cannot serve"):
        Socket(99999)


def test_what_is_no_serial_port(tmp_path):
    for each in ("/dev/null", str(tmp_path)):
        with pytest.raises(BadInput, match="it is no serial port"):
            Port(each)
    with pytest.raises(BadInput, match="this kind of port is not known"):
        Port("bogus://x")


def test_a_port_that_nobody_may_open(tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may open every port")
    assert "may not open" in refusal("/dev/mem", tmp_path)


def test_a_board_that_is_silent(tmp_path):
    far = Terminal()
    assert "silence" in refusal(far.address, tmp_path)
    far.close()


def test_a_board_of_another_version(tmp_path, monkeypatch):
    with Running(Terminal()) as board:
        monkeypatch.setattr("hannes.bench.session.VERSION", 9)
        said = refusal(board.far.address, tmp_path)
    assert "speaks version 1" in said and "version 9; update the older one" in said


def test_a_wrong_baud_rate(tmp_path):
    with Running(Terminal(), Misbehaviour(garbled=True)) as board:
        assert "wrong baud rate" in refusal(board.far.address, tmp_path)


def test_a_port_that_is_busy(tmp_path):
    with Running(Terminal()) as board, session(Link(board.far.address), tmp_path / "a") as talk:
        talk.hello()
        assert "busy" in refusal(board.far.address, tmp_path)


def test_a_deciding_process_that_hangs_has_the_board_stopped(tmp_path):
    """The reader alone would feed the watchdog for ever."""
    with Running(Terminal()) as board, session(Link(board.far.address), tmp_path / "a") as talk:
        talk.hello()
        talk.reader.send(talk.speaker.set_point(1.0))
        talk.wait(lambda: talk.moved, 2.0)
        talk.wait(lambda: False, 1.3)  # it waits, and lives
        assert board.logic.state is State.FOLLOWING
        time.sleep(1.4)
        assert board.logic.state is State.STOPPED
        for _ in talk.events():
            pass
        assert "hung" in talk.heard.lost


def test_a_stop_that_was_not_seen_is_said_on_ctrl_c(tmp_path):
    with Running(Terminal()) as board, pytest.raises(Interrupted) as ended:
        with session(Link(board.far.address), tmp_path / "a") as talk:
            talk.hello()
            talk.reader.send(talk.speaker.set_point(1.0))
            assert talk.wait(lambda: talk.moved, 5.0)
            board.cable = Cable(Misbehaviour(cut=1e-9))  # it is out from now on
            raise KeyboardInterrupt
    assert "not seen in the telemetry" in str(ended.value) and ended.value.exit_status == 130


def test_a_stop_that_could_not_be_sent_is_not_said_to_be(tmp_path):
    with Running(Socket(0)) as board, pytest.raises(ComputationFailed) as ended:
        with session(Link(board.far.address), tmp_path / "a") as talk:
            talk.hello()
            talk.profile([(0.0, 0.0), (5.0, 1.0)])
            board.far.cut()
            talk.run_to_end(5.0)
    assert "the link was lost" in str(ended.value) and "no stop could be sent" in str(ended.value)


def test_a_stop_that_was_seen_is_said_on_ctrl_c(tmp_path):
    with Running(Terminal()) as board, pytest.raises(Interrupted, match="the hand was stopped"):
        with session(Link(board.far.address), tmp_path / "a") as talk:
            talk.hello()
            raise KeyboardInterrupt


def recorded(monkeypatch, capsys, tmp_path, breaks):
    """Exit status and words of a `record` with which `breaks` interferes 0.3 s after its start."""
    monkeypatch.setattr("hannes.bench.record.require_within", lambda *_, **__: None)

    def run(talk, experiment):
        talk.profile([(0.0, 0.0), (5.0, 1.0)])
        talk.wait(lambda: False, 0.3)
        breaks(board)
        talk.run_to_end(5.0)

    monkeypatch.setattr("hannes.bench.record.run_command", run)
    with Running(Socket(0)) as board:
        asked = ["record", "void-closure", "--port", board.far.address]
        status = main([*asked, "--out", str(tmp_path / "a.h5")])
    return status, capsys.readouterr().err


def interrupt(board):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("breaks", "status", "stop"),
    [
        (lambda board: board.far.cut(), 3, "no stop could be sent"),
        (interrupt, 130, "the hand was stopped"),
        (lambda board: 1 / 0, 70, ""),
    ],
    ids=["lost link", "ctrl-c", "exception"],
)
def test_a_record_that_is_broken_off_writes_what_came(
    monkeypatch, capsys, tmp_path, breaks, status, stop
):
    monkeypatch.setenv("HANNES_CACHE", str(tmp_path / "cache"))
    found, said = recorded(monkeypatch, capsys, tmp_path, breaks)
    assert found == status and stop in said
    assert f"hannes record --recover {tmp_path}/a.h5.rawlog --out FILE" in said
    made = Recording.read(tmp_path / "a.h5")
    assert 0.2 < made.time[-1] < 1.5
    assert made == recover(tmp_path / "a.h5.rawlog")


def test_a_board_that_said_nothing_leaves_a_log_to_be_deleted(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("hannes.bench.record.require_within", lambda *_, **__: None)
    monkeypatch.setattr("hannes.bench.session.HELLO_TIME", 0.5)
    far = Terminal()
    asked = ["record", "void-closure", "--port", far.address, "--out", str(tmp_path / "a.h5")]
    assert main(asked) == 2
    said = capsys.readouterr().err
    assert f"{tmp_path}/a.h5.rawlog has no sample" in said and "silence" in said
    far.close()


def test_what_a_board_said_before_it_heard_the_stop_is_no_sign_of_it(tmp_path):
    with Running(Terminal()) as board:
        with session(Link(board.far.address), tmp_path / "a") as talk:
            talk.hello()
            read, later = board.far.read, board.moment + 0.3
            board.far.read = lambda: read() if board.moment > later else b""
        assert board.logic.state is State.STOPPED


def test_a_board_that_is_reset_is_named_and_its_samples_go_on(tmp_path):
    log = tmp_path / "run.rawlog"
    with Running(Terminal()) as board, pytest.raises(ComputationFailed, match="began anew"):
        with session(Link(board.far.address), log) as talk:
            talk.hello()
            talk.profile([(0.0, 0.0), (5.0, 1.0)])
            talk.wait(lambda: False, 0.3)
            board.logic = BoardLogic(Lag(), board.settings)  # as a reset does
            talk.run_to_end(5.0)
    rows = read_rows(log)
    assert "the board began anew" in [words for _, words in rows.events]
    assert rows.start is not None and np.diff(rows.board).max() < 0.1  # of the life of the profile
    assert rows.values[-1, 0] > 0.0
