"""A board that does not get its turn: its clock goes on, and the frames in between are missing."""

from types import SimpleNamespace

import pytest

from hannes.bench import virtual_board
from hannes.bench.board_logic import BoardLogic, Settings
from hannes.bench.misbehaviour import Misbehaviour
from hannes.bench.virtual_board import BEHIND, VirtualBoard
from tests.toy_machine import Lag


class Nowhere:
    """An end of a cable that nobody holds."""

    address = ""

    def read(self):
        return b""

    def write(self, data):
        pass

    def cut(self):
        pass

    def close(self):
        pass


def test_missed_ticks_take_time():
    logic = BoardLogic(Lag(), Settings())
    first = logic.tick()[0]
    logic.missed(250)
    second = logic.tick()[0]
    assert second.time - first.time == 251 * 1_000_000 // Settings().rate


def held_up(monkeypatch, on_time):
    """How far a board's clock is behind [s], once it was held up for three times BEHIND."""
    clock = SimpleNamespace(now=0.0)
    clock.monotonic = lambda: clock.now

    def sleep(seconds):
        clock.now += seconds

    clock.sleep = sleep
    monkeypatch.setattr(virtual_board, "time", clock)
    board = VirtualBoard(Lag, Nowhere(), Settings(), Misbehaviour(), on_time)

    def until():
        if board.ticks == 10:
            clock.now += 3.0 * BEHIND  # as where other processes have the processor
        return clock.now > 5.0 * BEHIND

    board.run(until)
    return clock.now - 1e-6 * board.logic.time


def test_the_clock_of_hardware_goes_on_where_ticks_are_missed(monkeypatch):
    assert abs(held_up(monkeypatch, on_time=True)) < 0.003


def test_a_virtual_machine_waits_with_its_clock(monkeypatch):
    assert held_up(monkeypatch, on_time=False) == pytest.approx(3.0 * BEHIND, abs=0.003)
