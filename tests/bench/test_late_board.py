"""A board that does not get its turn: its clock goes on, and the frames in between are missing."""

import time

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


def held_up(on_time):
    """How far a board's clock is behind [s], once it was held up for three times BEHIND."""
    board = VirtualBoard(Lag, Nowhere(), Settings(), Misbehaviour(), on_time)
    began, held = time.monotonic(), []

    def until():
        if not held:
            held.append(time.sleep(3.0 * BEHIND))  # as where other processes have the processor
        return time.monotonic() - began > 5.0 * BEHIND

    board.run(until)
    return time.monotonic() - began - 1e-6 * board.logic.time


def test_the_clock_of_hardware_goes_on_where_ticks_are_missed():
    assert -0.01 < held_up(on_time=True) < 1.5 * BEHIND


def test_a_virtual_machine_waits_with_its_clock():
    assert held_up(on_time=False) > 2.5 * BEHIND
