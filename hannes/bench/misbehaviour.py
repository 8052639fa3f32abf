"""What goes wrong on a cable, on demand: shares of packets, and moments at which it is cut."""

import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Misbehaviour:
    """Shares of packets (0 to 1) that are lost, repeated or damaged; delays and cuts [s].

    late:    longest delay of a packet; stall: every that many seconds nothing goes for as long
    again as `stall_for`; cut: the cable is out from then on, for `cut_for` (0: for good);
    reset: the board starts anew then; garbled: every byte is another (a wrong baud rate).
    """

    lost: float = 0.0
    repeated: float = 0.0
    damaged: float = 0.0
    late: float = 0.0
    stall: float = 0.0
    stall_for: float = 0.0
    cut: float = 0.0
    cut_for: float = 0.0
    reset: float = 0.0
    garbled: bool = False
    drift: float = 0.0  # of the board's clock: 40e-6 is 40 ppm fast
    seed: int = 1


class Cable:
    """Passes packets on, or not, by a Misbehaviour; time [s] is given with each call."""

    def __init__(self, how: Misbehaviour) -> None:
        self.how = how
        self._chance = random.Random(how.seed)
        self._waiting: list[tuple[float, bytes]] = []

    def is_out(self, time: float) -> bool:
        """Whether the cable is out at `time`."""
        how = self.how
        return (
            bool(how.cut) and time >= how.cut and (not how.cut_for or time < how.cut + how.cut_for)
        )

    def send(self, packets: list[bytes], time: float) -> bytes:
        """Take packets of the board at `time`; return the bytes that reach the host then."""
        how = self.how
        for packet in packets:
            if self._chance.random() < how.lost:
                continue
            times = 2 if self._chance.random() < how.repeated else 1
            for _ in range(times):
                when = time + how.late * self._chance.random() if how.late else time
                self._waiting.append((when, self._worn(packet)))
        if self.is_out(time):
            self._waiting = []
            return b""
        if how.stall and time % how.stall > how.stall - how.stall_for:
            return b""
        due = [packet for when, packet in self._waiting if when <= time]
        self._waiting = [each for each in self._waiting if each[0] > time]
        data = b"".join(due)
        return bytes(b ^ 0x5A | 1 for b in data) if how.garbled else data

    def _worn(self, packet: bytes) -> bytes:
        """Damage one byte of a share of packets."""
        if self._chance.random() >= self.how.damaged:
            return packet
        at = self._chance.randrange(len(packet))
        changed = packet[at] ^ self._chance.randrange(1, 256)
        return packet[:at] + bytes([changed]) + packet[at + 1 :]
