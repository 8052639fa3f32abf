"""What a board does with frames and ticks, without a clock or a port of its own.

The reference firmware in C (firmware/) follows the same rules; the tests hold one against the
other. A machine is whatever moves: the virtual hand, a servo, a hand on real hardware.
"""

import zlib
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from hannes.bench.frames import Frame
from hannes.bench.messages import (
    FROM_HOST,
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

MICRO = 1e-6
PULSE_PERIOD = 100_000  # us between two pulses
MOVING = (State.RUNNING, State.FOLLOWING)
UNPACK = {message.KIND: message for message in FROM_HOST}
HOST_LENGTHS = lengths(FROM_HOST)


class Machine(Protocol):
    """What a board drives. `temperature` [degC] and `travel` [rad] are checked against limits."""

    channels: tuple[Channel, ...]

    def step(self, reference: float | None) -> dict[str, float]:
        """Go on by one tick towards `reference` [rad]; None opens the drive.

        Returns the measured values by channel name [the channels' units].
        """
        ...


@dataclass(frozen=True)
class Limits:
    """Beyond these a board stops by itself: current [A], winding [degC], output shaft [rad]."""

    current: float = 6.0
    temperature: float = 120.0
    travel_low: float = -1.0
    travel_high: float = 40.0


@dataclass(frozen=True)
class Settings:
    """Rate [Hz], watchdog [us], frames kept to be sent again, points of a profile kept."""

    firmware: str = "hannes virtual 1"
    rate: int = 1000
    watchdog: int = 200_000
    ring: int = 2048
    profile_points: int = 4096
    limits: Limits = field(default_factory=Limits)


class BoardLogic:
    """State of a board: call `hear` for each frame that came and `tick` once a period."""

    def __init__(self, machine: Machine, settings: Settings | None = None) -> None:
        self.machine = machine
        self.settings = settings or Settings()
        self.telemetry = Telemetry(machine.channels)
        self.state = State.IDLE
        self.time = 0  # us
        self._sequence = 0
        self._ring: deque[Frame] = deque(maxlen=self.settings.ring)
        self._heard, self._beat, self._refused, self._dropped = 0, 0, 0, 0
        self._profile: dict[int, tuple[int, int]] = {}
        self._expected: Profile | None = None
        self._began, self._reference, self._at = 0, 0.0, 0
        self._pulsed = -PULSE_PERIOD

    def hear(self, frame: Frame) -> list[Frame]:
        """Take one frame of the host; return what is to be sent at once."""
        self._heard = self.time
        message = UNPACK[Kind(frame.kind)].unpack(frame.payload)
        handle: dict[type, Callable[..., Reason | list[Frame]]] = {
            Ask: self._introduce,
            Alive: self._alive,
            Profile: self._expect,
            Points: self._points,
            Start: self._start,
            SetPoint: self._follow,
            Stop: self._stop,
            Resend: self._again,
        }
        done = handle[type(message)](message)
        if isinstance(done, list):
            return done
        self._refused += done is not Reason.DONE
        return [self._frame(Kind.ANSWER, Answer(frame.sequence, frame.kind, done).pack())]

    def missed(self, ticks: int) -> None:
        """So many periods went by without a tick: the clock goes on, and frames are lost."""
        self.time += ticks * (1_000_000 // self.settings.rate)

    def tick(self) -> list[Frame]:
        """Drive the machine for one period; return telemetry, and a pulse when one is due."""
        self._watch()
        values = self.machine.step(self._wanted())
        self._limit(values)
        row = tuple(values[channel.name] for channel in self.machine.channels)
        frames = [self._frame(Kind.TELEMETRY, self.telemetry.pack(row))]
        self.time += 1_000_000 // self.settings.rate
        if self.time - self._pulsed >= PULSE_PERIOD:
            self._pulsed = self.time
            pulse = Pulse(self.state, self._beat, self._refused, self._dropped)
            frames.append(self._frame(Kind.PULSE, pulse.pack()))
        return frames

    def damaged(self, count: int) -> None:
        """Note `count` frames of the host that failed their checks."""
        self._dropped += count

    def _frame(self, kind: Kind, payload: bytes) -> Frame:
        frame = Frame(kind, self._sequence, self.time, payload)
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        self._ring.append(frame)
        return frame

    def _introduce(self, message: Ask) -> list[Frame]:
        settings = self.settings
        hello = Hello(
            VERSION,
            settings.firmware,
            settings.rate,
            settings.watchdog,
            settings.ring,
            settings.profile_points,
            len(self.machine.channels),
        )
        frames = [self._frame(Kind.HELLO, hello.pack())]
        return frames + [self._frame(Kind.CHANNEL, c.pack()) for c in self.machine.channels]

    def _alive(self, message: Alive) -> list[Frame]:
        self._beat = message.beat
        pulse = Pulse(self.state, self._beat, self._refused, self._dropped)
        return [self._frame(Kind.PULSE, pulse.pack())]

    def _expect(self, message: Profile) -> Reason:
        if self.state in MOVING:
            return Reason.BUSY
        if message.points > self.settings.profile_points:
            return Reason.TOO_LONG
        self._expected, self._profile = message, {}
        return Reason.DONE

    def _points(self, message: Points) -> Reason:
        if self._expected is None:
            return Reason.INCOMPLETE
        for k, point in enumerate(message.points):
            if message.first + k < self._expected.points:
                self._profile[message.first + k] = point
        return Reason.DONE

    def _start(self, message: Start) -> Reason:
        if self.state in MOVING:
            return Reason.BUSY
        expected = self._expected
        if expected is None or len(self._profile) != expected.points or not expected.points:
            return Reason.INCOMPLETE
        if (
            profile_check(self._points_in_order()) != expected.check
            or message.check != expected.check
        ):
            return Reason.INCOMPLETE
        if not all(self._within(value) for _, value in self._profile.values()):
            return Reason.BEYOND_LIMITS
        self.state, self._began, self._at = State.RUNNING, self.time, 0
        return Reason.DONE

    def _follow(self, message: SetPoint) -> Reason:
        if self.state is State.RUNNING:
            return Reason.BUSY
        if not self._within(message.reference):
            return Reason.BEYOND_LIMITS
        self.state, self._reference = State.FOLLOWING, message.reference * MICRO
        return Reason.DONE

    def _stop(self, message: Stop) -> Reason:
        self.state = State.STOPPED
        return Reason.DONE

    def _again(self, message: Resend) -> list[Frame] | Reason:
        asked = [f for f in self._ring if (f.sequence - message.first) % (1 << 32) < message.count]
        return asked or Reason.NOT_KEPT

    def _within(self, reference: int) -> bool:
        limits = self.settings.limits
        return limits.travel_low <= reference * MICRO <= limits.travel_high

    def _points_in_order(self) -> list[tuple[int, int]]:
        return [self._profile[k] for k in sorted(self._profile)]

    def _watch(self) -> None:
        """Stop where the host was not heard for longer than the watchdog allows."""
        if self.state in MOVING and self.time - self._heard > self.settings.watchdog:
            self.state = State.WATCHDOG

    def _wanted(self) -> float | None:
        """Reference of this tick [rad], or None where the drive is open."""
        if self.state is State.FOLLOWING:
            return self._reference
        if self.state is not State.RUNNING or self._expected is None:
            return None
        since = self.time - self._began
        if since > self._expected.duration:
            self.state = State.IDLE
            return None
        while self._at + 2 < len(self._profile) and self._profile[self._at + 1][0] <= since:
            self._at += 1
        return between(self._profile[self._at], self._profile.get(self._at + 1), since)

    def _limit(self, values: dict[str, float]) -> None:
        """Stop where current, temperature or travel are beyond their limits."""
        if self.state not in MOVING:
            return
        limits = self.settings.limits
        if abs(values.get("current", 0.0)) > limits.current:
            self.state = State.OVER_CURRENT
        elif values.get("temperature", 0.0) > limits.temperature:
            self.state = State.OVER_TEMPERATURE
        elif not limits.travel_low <= values.get("position", 0.0) <= limits.travel_high:
            self.state = State.OVER_TRAVEL


def between(first: tuple[int, int], second: tuple[int, int] | None, since: int) -> float:
    """Reference [rad] at `since` [us] on the line from one point of a profile to the next."""
    if second is None or since <= first[0]:
        return first[1] * MICRO
    if since >= second[0]:
        return second[1] * MICRO
    share = (since - first[0]) / (second[0] - first[0])
    return (first[1] + share * (second[1] - first[1])) * MICRO


def profile_check(points: list[tuple[int, int]]) -> int:
    """CRC-32 of a profile: times [us] and references [urad], little-endian."""
    import struct

    return zlib.crc32(b"".join(struct.pack("<Ii", *point) for point in points))
