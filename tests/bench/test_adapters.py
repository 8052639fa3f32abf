"""Boards of others against simulated devices: a bus servo that is polled, a board of text lines."""

import threading
import time

import numpy as np
import pytest

from hannes.bench.adapters.feetech import CURRENT, READ, STEP, WRITE, Feetech, signed
from hannes.bench.adapters.text_lines import TextLines
from hannes.bench.events import About, Row
from hannes.bench.finish import read_rows, recording
from hannes.bench.reader import Link
from hannes.bench.session import session
from hannes.bench.virtual_board import Terminal


class Device(threading.Thread):
    """A device on a pseudo-terminal: `hear` is given what the host says."""

    def __init__(self) -> None:
        super().__init__()
        self.far, self.over, self.goal, self.position = Terminal(), threading.Event(), 0.0, 0.0
        self.torque = True

    def run(self) -> None:
        while not self.over.is_set():
            self.hear(self.far.read())
            if self.torque:
                self.position += 0.1 * (self.goal - self.position)
            self.go_on()
            time.sleep(1e-3)

    def go_on(self) -> None:
        """Nothing happens by itself."""

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.join()
        self.far.close()


class Servo(Device):
    """A Feetech STS of the maker's manual: answers to reads and writes, with a checksum."""

    rest = b""

    def hear(self, data) -> None:
        self.rest += data
        while (at := self.rest.find(b"\xff\xff")) >= 0 and len(self.rest) >= at + 4:
            end = at + 4 + self.rest[at + 3]
            if len(self.rest) < end:
                return
            servo, length, what, *rest = self.rest[at + 2 : end]
            self.rest = self.rest[end:]
            assert sum((servo, length, what, *rest)) & 0xFF == 0xFF
            self.answer(what, bytes(rest[:-1]))

    def answer(self, what, data) -> None:
        said = b""
        if what == READ:
            assert data == bytes([56, 15])
            said = self.measured()
        elif what == WRITE and data[0] == 42:
            self.goal = STEP * signed(int.from_bytes(data[1:], "little"))
        elif what == WRITE and data[0] == 40:
            self.torque = bool(data[1])
        body = bytes([1, len(said) + 2, 0]) + said
        self.far.write(b"\xff\xff" + body + bytes([~sum(body) & 0xFF]))

    def measured(self) -> bytes:
        steps, current = round(self.position / STEP), round((self.goal - self.position) / CURRENT)
        words = [abs(x) | (x < 0) << 15 for x in (steps, 0)]
        words += [250 | 1 << 10]  # a load of a quarter, against the goal
        data = b"".join(each.to_bytes(2, "little") for each in words) + bytes([120, 31])
        return data + bytes(5) + (abs(current) | (current < 0) << 15).to_bytes(2, "little")


class Printing(Device):
    """An Arduino that prints a header and lines, and obeys `r`, `s` and `?`."""

    def hear(self, data) -> None:
        for line in data.decode().splitlines():
            if line == "?":
                self.far.write(b"# time_us position_rad current_A\n")
            elif line.startswith("r "):
                self.goal = float(line[2:])
            elif line == "s":
                self.torque = False

    def go_on(self) -> None:
        values = self.position, self.goal - self.position
        self.far.write(b"%d %.6f %.6f\n" % (time.monotonic_ns() // 1000, *values))


@pytest.mark.parametrize("device, board", [(Servo, "feetech"), (Printing, "text")])
def test_a_device_is_moved_recorded_and_stopped(device, board, tmp_path):
    log = tmp_path / "run.rawlog"
    with device() as far:
        with session(Link(far.far.address, board), log) as talk:
            about = talk.hello()
            talk.reader.send(talk.speaker.set_point(-1.5))
            assert talk.wait(lambda: far.position < -1.4, 5.0)
            talk.wait(lambda: False, 0.1)
        assert not far.torque  # leaving stops it
    made = recording(read_rows(log))
    assert made["position"][-1] == pytest.approx(-1.5, abs=0.1)
    assert made["position"].max() < 0.1
    assert {"position", "current"} <= set(about.channels) and about.channels["position"] == "rad"
    assert np.abs(made["current"]).max() > 0.2


def test_all_that_a_servo_measures_has_its_unit():
    servo, adapter = Servo(), Feetech()
    servo.position, servo.goal = -1.0, 0.5
    written = []
    servo.far.close()
    servo.far = type("Written", (), {"write": staticmethod(written.append)})
    servo.hear(adapter.poll())
    first, last = written[0][:9], written[0][9:]
    assert adapter.feed(first, 1.0) == []
    about, row = adapter.feed(last, 2.0)
    assert isinstance(about, About) and isinstance(row, Row) and row.time == 2.0
    position, speed, duty, supply, temperature, current = row.values
    assert position == pytest.approx(-1.0, abs=STEP) and speed == 0.0
    assert (duty, supply, temperature) == pytest.approx((-0.25, 12.0, 31.0))
    assert current == pytest.approx(1.5, abs=CURRENT)
    worn = bytearray(written[0])
    worn[7] ^= 4
    assert adapter.feed(bytes(worn), 3.0) == [] and adapter.damaged > 0
    assert len(adapter.feed(written[0], 4.0)) == 1  # the next is read


@pytest.mark.parametrize("line", [b"time_us:1000 position_rad:0.5 x:2", b"1000 0.5 2"])
def test_pairs_and_columns_are_read(line):
    board = TextLines("" if b":" in line else "time_us position_rad x")
    about, row = board.feed(line + b"\n", 9.0)
    assert about.channels == {"position": "rad", "x": "1"}
    assert (row.time, row.values) == (1e-3, (0.5, 2.0))
    assert board.feed(b"1000 0.5\nnan 1 2\n", 9.0) == [] and board.damaged == 2
