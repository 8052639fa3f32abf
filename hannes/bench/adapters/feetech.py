"""Feetech STS servos (and others of that family): a worked example of a bus that is polled.

Half-duplex frames FF FF | id | length | instruction or error | data | checksum, where the checksum
is the inverted sum of all after FF FF (Feetech, "Communication protocol manual SCS/STS", 2020;
Dynamixel's protocol 1.0 is the same). Present position, speed, load, voltage, temperature and
current stand from address 56 on, little-endian, sign in bit 15 (load: bit 10).
"""

import math

from hannes.bench.events import About, Event, Row

READ, WRITE = 2, 3
PRESENT, PRESENT_BYTES = 56, 15  # position .. current
GOAL, TORQUE = 42, 40
TURN = 4096  # steps
STEP = 2.0 * math.pi / TURN  # rad
CURRENT = 6.5e-3  # A a step
CHANNELS = {
    "position": "rad",
    "speed": "rad/s",
    "duty": "1",
    "supply": "V",
    "temperature": "degC",
    "current": "A",
}


def packet(servo: int, instruction: int, data: bytes) -> bytes:
    """Return one instruction packet."""
    body = bytes([servo, len(data) + 2, instruction]) + data
    return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])


def signed(value: int, bit: int = 15) -> int:
    """Value of a sign-and-magnitude number whose sign is in `bit`."""
    return -(value & ~(1 << bit)) if value >> bit & 1 else value


class Feetech:
    """Adapter for one servo with number `servo`, asked `rate` [Hz] times a second."""

    name = "feetech"
    baud = 1_000_000

    def __init__(self, servo: int = 1, rate: float = 200.0) -> None:
        self.servo, self.rate, self.polls = servo, rate, 1.0 / rate
        self._rest, self._number, self._damaged, self._said = b"", 0, 0, False

    def ask(self) -> bytes:
        """Ask for the first sample."""
        return self.poll()

    def alive(self, beat: int) -> bytes:
        """Nothing: these servos have no watchdog."""
        return b""

    def poll(self) -> bytes:
        """Ask for all that is measured at present."""
        return packet(self.servo, READ, bytes([PRESENT, PRESENT_BYTES]))

    def profile(self, points: list[tuple[float, float]]) -> list[bytes]:
        """None: the servo follows set points only."""
        return []

    def start(self) -> bytes:
        """Nothing: there is no profile."""
        return b""

    def set_point(self, reference: float) -> bytes:
        """Write the goal position."""
        steps = round(reference / STEP)
        raw = steps if steps >= 0 else -steps | 1 << 15
        return packet(self.servo, WRITE, bytes([GOAL]) + raw.to_bytes(2, "little"))

    def stop(self) -> bytes:
        """Switch the torque off."""
        return packet(self.servo, WRITE, bytes([TORQUE, 0]))

    def resend(self, first: int, count: int) -> bytes:
        """Nothing: the servo keeps no samples."""
        return b""

    def feed(self, data: bytes, host_time: float) -> list[Event]:
        """Samples in the whole packets of `data`."""
        self._rest += data
        events: list[Event] = []
        while (found := self._next()) is not None:
            if found[0] == self.servo and len(found) == PRESENT_BYTES + 3:
                events += self._sample(found[3:], host_time)
        return events

    @property
    def damaged(self) -> int:
        """Packets so far whose checksum is wrong."""
        return self._damaged

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Unknown: answers have no numbers."""
        return ()

    def _next(self) -> bytes | None:
        """The next whole packet without its head and checksum, or None."""
        while (at := self._rest.find(b"\xff\xff")) >= 0:
            self._rest = self._rest[at:]
            if len(self._rest) < 4 or len(self._rest) < 4 + self._rest[3]:
                return None
            end = 4 + self._rest[3]
            body, check = self._rest[2 : end - 1], self._rest[end - 1]
            if self._rest[3] >= 2 and ~sum(body) & 0xFF == check:
                self._rest = self._rest[end:]
                return body
            self._damaged += 1
            self._rest = self._rest[1:]
        self._rest = self._rest[-1:]
        return None

    def _sample(self, data: bytes, host_time: float) -> list[Event]:
        position, speed, load = (int.from_bytes(data[k : k + 2], "little") for k in (0, 2, 4))
        current = int.from_bytes(data[13:15], "little")
        values = (
            signed(position) * STEP,
            signed(speed) * STEP,
            signed(load, 10) * 1e-3,
            data[6] * 0.1,
            float(data[7]),
            signed(current) * CURRENT,
        )
        self._number += 1
        row = Row(self._number, host_time, values)
        if self._said:
            return [row]
        self._said = True
        return [About("Feetech STS", dict(CHANNELS), self.rate, 0.0), row]
