"""Boards that speak the protocol of `hannes/bench/messages.py`, the virtual board among them."""

import math

from hannes.bench.board_logic import profile_check
from hannes.bench.events import About, Event, OtherVersion, Reply, Restarted, Row, Status
from hannes.bench.frames import ANY, Frame, Splitter, encode
from hannes.bench.lives import Lives
from hannes.bench.messages import (
    AT_ONCE,
    FROM_BOARD,
    VERSION,
    Alive,
    Answer,
    Ask,
    Channel,
    Hello,
    Kind,
    Points,
    Profile,
    Pulse,
    Reason,
    Resend,
    SetPoint,
    Start,
    State,
    Stop,
    Telemetry,
    lengths,
)
from hannes.bench.sequence import MOST_GAPS, Received

MICRO = 1e-6
CODES = frozenset("bBhHiIqQfd")  # of a channel, as Python's struct has them


class Framed:
    """Adapter for COBS frames with numbers, board time and CRC."""

    name = "hannes"
    baud = 1_000_000
    polls = 0.0

    def __init__(self) -> None:
        self._lengths = {**lengths(FROM_BOARD), Kind.TELEMETRY: ANY}  # until the hello says it
        self._splitter = Splitter(self._lengths)
        self._received, self._lives = Received(), Lives()
        self._before: tuple[tuple[int, int], ...] = ()  # missing in the board's earlier lives
        self._hello: Hello | None = None
        self._channels: dict[int, Channel] = {}
        self._telemetry: Telemetry | None = None
        self._number, self._check, self._refused = 0, 0, 0

    def ask(self) -> bytes:
        """Bytes that make the board introduce itself."""
        return self._packet(Ask())

    def alive(self, beat: int) -> bytes:
        """Bytes that feed the watchdog."""
        return self._packet(Alive(beat & 0xFFFFFFFF))

    def poll(self) -> bytes:
        """Nothing: the board speaks by itself."""
        return b""

    def profile(self, points: list[tuple[float, float]]) -> list[bytes]:
        """Packets of a whole profile of (time [s], reference [rad])."""
        raw = [(round(t / MICRO), round(reference / MICRO)) for t, reference in points]
        self._check = profile_check(raw)
        packets = [self._packet(Profile(len(raw), raw[-1][0], self._check))]
        for first in range(0, len(raw), AT_ONCE):
            some = raw[first : first + AT_ONCE]
            some += [some[-1]] * (AT_ONCE - len(some))
            packets.append(self._packet(Points(first, tuple(some))))
        return packets

    def start(self) -> bytes:
        """Bytes that run the profile sent last."""
        return self._packet(Start(self._check))

    def set_point(self, reference: float) -> bytes:
        """Bytes that make the board follow `reference` [rad]."""
        return self._packet(SetPoint(round(reference / MICRO)))

    def stop(self) -> bytes:
        """Bytes that open the drive."""
        return self._packet(Stop())

    def resend(self, first: int, count: int) -> bytes:
        """Bytes that ask for `count` frames again, from number `first` on."""
        return self._packet(Resend(first, count))

    def feed(self, data: bytes, host_time: float) -> list[Event]:
        """What the whole frames in `data` say, each once."""
        events: list[Event] = []
        for frame in self._splitter.feed(data):
            if frame.kind == Kind.TELEMETRY and self._telemetry is None:
                continue  # sound, but nobody knows yet of what
            if self._lives.is_new(frame):
                self._before, self._received = self.missing[-MOST_GAPS:], Received()
                events.append(Restarted(frame.time * MICRO))
            if self._received.accept(frame.sequence):
                events += self._event(frame)
        return events

    @property
    def damaged(self) -> int:
        """Frames so far that failed their checks."""
        return self._splitter.damaged + self._refused

    @property
    def missing(self) -> tuple[tuple[int, int], ...]:
        """Intervals of frame numbers that never came."""
        return self._before + self._received.missing

    def _packet(
        self, message: "Ask | Alive | Profile | Points | Start | SetPoint | Stop | Resend"
    ) -> bytes:
        self._number = (self._number + 1) & 0xFFFFFFFF
        return encode(Frame(message.KIND, self._number, 0, message.pack()))

    def _event(self, frame: Frame) -> list[Event]:
        time = frame.time / 1e6
        if frame.kind == Kind.TELEMETRY and self._telemetry is not None:
            return [Row(frame.sequence, time, self._telemetry.unpack(frame.payload))]
        if frame.kind == Kind.PULSE:
            pulse = Pulse.unpack(frame.payload)
            state = State(pulse.state) if pulse.state in set(State) else State.STOPPED
            return [Status(time, state, pulse.beat, pulse.refused, pulse.dropped)]
        if frame.kind == Kind.ANSWER:
            answer = Answer.unpack(frame.payload)
            reason = Reason(answer.reason) if answer.reason in set(Reason) else Reason.UNKNOWN
            return [Reply(time, answer.request, answer.kind, reason)]
        if frame.kind == Kind.HELLO:
            return self._greeted(Hello.unpack(frame.payload))
        return self._described(Channel.unpack(frame.payload))

    def _greeted(self, hello: Hello) -> list[Event]:
        if hello.version != VERSION:
            return [OtherVersion(hello.version)]
        self._hello, self._channels = hello, {}
        return []

    def _described(self, channel: Channel) -> list[Event]:
        """Once all channels are known, telemetry has a length, and the board is known."""
        if not _is_readable(channel):
            self._refused += 1
            return []
        self._channels[channel.index] = channel
        if self._hello is None or len(self._channels) != self._hello.channels:
            return []
        channels = tuple(self._channels[k] for k in sorted(self._channels))
        if len({each.name for each in channels}) < len(channels):
            self._refused += 1
            return []
        self._telemetry = Telemetry(channels)
        self._lengths[Kind.TELEMETRY] = self._telemetry.format.size
        units = {each.name: each.unit for each in channels}
        hello = self._hello
        return [About(hello.firmware, units, float(hello.rate), hello.watchdog / 1e6)]


def _is_readable(channel: Channel) -> bool:
    """Whether a channel can be read: its CRC was right, and yet it may come from anybody."""
    known = channel.code in CODES and math.isfinite(channel.scale) and channel.scale != 0.0
    return known and channel.name.isidentifier() and channel.unit.isprintable()
