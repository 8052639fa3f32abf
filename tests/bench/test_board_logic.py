"""The rules of a board: profiles, set points, watchdog, limits, frames sent again."""

import pytest
from toy_machine import Lag

from hannes import load_experiment
from hannes.bench.adapters.framed import Framed
from hannes.bench.board_logic import HOST_LENGTHS, BoardLogic, Limits, Settings
from hannes.bench.events import About, Reply, Row, Status
from hannes.bench.frames import Splitter, encode
from hannes.bench.messages import Kind, Reason, State
from hannes.bench.virtual_hand import VirtualHand


class Wire:
    """Board and adapter with nothing between them."""

    def __init__(self, **settings) -> None:
        self.board = BoardLogic(Lag(), Settings(**settings))
        self.host = Framed()
        self._splitter = Splitter(HOST_LENGTHS)

    def say(self, packet: bytes):
        sent = [f for frame in self._splitter.feed(packet) for f in self.board.hear(frame)]
        return self.host.feed(b"".join(map(encode, sent)), 0.0)

    def ticks(self, count: int):
        frames = [f for _ in range(count) for f in self.board.tick()]
        return self.host.feed(b"".join(map(encode, frames)), 0.0)


RAMP = [(0.0, 0.0), (0.05, 1.0), (0.1, 0.0)]


def reasons(events):
    return [event.reason for event in events if isinstance(event, Reply)]


def test_a_board_introduces_itself():
    (about,) = Wire().say(Framed().ask())
    assert about == About(
        "hannes virtual 1", {"reference": "rad", "position": "rad", "current": "A"}, 1000.0, 0.2
    )


def test_a_profile_runs_to_its_end():
    wire = Wire()
    wire.say(wire.host.ask())
    for packet in wire.host.profile(RAMP):
        assert reasons(wire.say(packet)) == [Reason.DONE]
    assert reasons(wire.say(wire.host.start())) == [Reason.DONE]
    rows = [event for event in wire.ticks(150) if isinstance(event, Row)]
    references = [row.values[0] for row in rows]
    assert references[25] == pytest.approx(0.5, abs=1e-6)
    assert max(references) == pytest.approx(1.0)
    assert wire.board.state is State.IDLE


def test_a_profile_of_which_a_part_was_lost_does_not_start():
    wire = Wire()
    wire.say(wire.host.ask())
    first, *_ = wire.host.profile([(0.01 * k, 0.0) for k in range(20)])
    wire.say(first)
    assert reasons(wire.say(wire.host.start())) == [Reason.INCOMPLETE]


def test_a_profile_beyond_the_limits_is_refused():
    wire = Wire(limits=Limits(travel_high=0.5))
    for packet in wire.host.profile(RAMP):
        wire.say(packet)
    assert reasons(wire.say(wire.host.start())) == [Reason.BEYOND_LIMITS]


def test_set_points_are_followed_until_the_watchdog():
    wire = Wire(watchdog=20_000)
    wire.say(wire.host.ask())
    wire.say(wire.host.set_point(1.0))
    wire.ticks(20)
    assert wire.board.state is State.FOLLOWING
    wire.ticks(2)
    assert wire.board.state is State.WATCHDOG


def test_a_current_beyond_its_limit_stops_the_board():
    wire = Wire(limits=Limits(current=0.5))
    wire.say(wire.host.ask())
    wire.say(wire.host.set_point(1.0))
    wire.ticks(1)
    assert wire.board.state is State.OVER_CURRENT
    held = wire.board.machine.position
    wire.ticks(5)
    assert wire.board.machine.position == held


def test_travel_beyond_its_limit_stops_the_board():
    wire = Wire(limits=Limits(travel_high=0.5))
    wire.board.machine.position = 0.6  # pushed there from outside
    wire.say(wire.host.ask())
    wire.say(wire.host.set_point(0.4))
    wire.ticks(1)
    assert wire.board.state is State.OVER_TRAVEL


def test_a_winding_that_warms_beyond_its_limit_stops_the_board():
    """A hand that squeezes on warms its winding; one that is open does not."""
    (variant,) = load_experiment("dynamometer")
    for reference, state in ((9.0, State.OVER_TEMPERATURE), (0.0, State.FOLLOWING)):
        machine = VirtualHand(variant.hand, variant.experiment)
        board = BoardLogic(machine, Settings(limits=Limits(temperature=26.0), watchdog=10_000_000))
        for frame in Splitter(HOST_LENGTHS).feed(Framed().set_point(reference)):
            board.hear(frame)
        for _ in range(2000):
            board.tick()
        assert board.state is state


def test_what_was_lost_is_sent_again():
    wire = Wire()
    wire.say(wire.host.ask())
    wire.ticks(3)
    lost = wire.board.tick()
    wire.ticks(1)
    assert wire.host.missing == ((lost[0].sequence, lost[-1].sequence + 1),)
    again = wire.say(wire.host.resend(lost[0].sequence, len(lost)))
    assert [type(event) for event in again] == [Row]
    assert wire.host.missing == ()
    assert reasons(wire.say(wire.host.resend(10**6, 1))) == [Reason.NOT_KEPT]


def test_a_stop_is_seen_in_the_telemetry():
    wire = Wire()
    wire.say(wire.host.set_point(1.0))
    wire.ticks(5)
    assert reasons(wire.say(wire.host.stop())) == [Reason.DONE]
    (status,) = [e for e in wire.say(wire.host.alive(7)) if isinstance(e, Status)]
    assert (status.state, status.beat) == (State.STOPPED, 7)
    assert Kind.STOP
