"""The loop on a simulated board: soft objects squeezed less, rigid ones held, the haptic signal."""

from functools import partial

import numpy as np
import pytest

from hannes.bench.events import About, Row
from hannes.bench.grip_loop import GripLoop, GripPlan
from hannes.bench.haptics import HapticSettings
from hannes.bench.simulated_board import grasped

FULL, SPEED = 9.84, 9.84 / 0.637


def held(board, loop, ticks=1300):
    """Forces [N] of a grasp, and what was said."""
    said, force = [], []
    for each in grasped(board, loop, lambda time: min(SPEED * time, FULL), ticks):
        said += each
        force.append(board.logic.machine.truth["force"])
    return np.array(force), said


@pytest.fixture(scope="module")
def grasps(model):
    """Forces without and with the policy, and what was said with it, by stiffness [N/m]."""
    from conftest import SimulatedBoard, holding

    found = {}
    for stiffness in (1500.0, 30e3):
        bare, _ = held(SimulatedBoard(holding(stiffness)), GripLoop(model, GripPlan(policy=False)))
        loop = GripLoop(model)
        found[stiffness] = bare, *held(SimulatedBoard(holding(stiffness)), loop), loop
    return found


def test_a_soft_object_is_squeezed_less(grasps):
    bare, limited, _, loop = grasps[1500.0]
    assert not loop.firm
    assert limited.max() < 0.7 * bare.max()


def test_a_rigid_object_is_held_firmly(grasps):
    bare, limited, _, loop = grasps[30e3]
    assert loop.firm
    assert limited[-1] > 0.95 * bare[-1]


def test_the_haptic_signal_says_contact_class_and_force(grasps):
    settings = HapticSettings()
    for stiffness, frequency in (
        (1500.0, settings.soft_frequency),
        (30e3, settings.rigid_frequency),
    ):
        commands = [each.haptic for each in grasps[stiffness][2] if each.haptic]
        assert len(commands) == pytest.approx(1.3 * settings.rate, abs=2)
        assert commands[0].amplitude == 0.0
        assert max(each.amplitude for each in commands) == 1.0  # the pulse at the contact
        assert commands[-1].frequency == frequency
    soft, rigid = ([s.haptic for s in grasps[k][2] if s.haptic][-1] for k in (1500.0, 30e3))
    assert 0.0 <= soft.squeeze < rigid.squeeze <= 1.0


def test_a_second_grasp_has_a_verdict_of_its_own(model):
    """A soft object, let go; then a rigid one, without a stop in between; and the other way."""
    from conftest import SimulatedBoard, holding

    times, angles = (0.0, 0.637, 1.2, 1.8, 2.1, 2.737), (0.0, FULL, FULL, 0.0, 0.0, FULL)
    for first, second in ((1500.0, 30e3), (30e3, 1500.0)):
        machine, loop, firm, released = holding(first), GripLoop(model), [], []
        command = partial(np.interp, xp=times, fp=angles)
        for tick, said in enumerate(grasped(SimulatedBoard(machine), loop, command, 3300)):
            if tick == 1900:
                machine._stepper.set_value("object_stiffness", second)
            firm.append(loop.firm)
            released.append(said[-1].released)
        assert firm[1199] is (first > 5500.0)
        assert not firm[1999]
        assert released[1999] and not released[2500]
        assert firm[-1] is (second > 5500.0)


def test_a_force_set_point_is_tracked(model, board):
    loop = GripLoop(model, GripPlan(force_wanted=20.0), Truth(board(8e3)))
    made = loop._observer.board
    force, _ = held(made, loop, 2500)
    assert force[-1] == pytest.approx(20.0, rel=0.1)
    assert force.max() < 40.0  # it closes at full speed until the touch is detected


class Truth:
    """An observer that knows the force."""

    def __init__(self, made) -> None:
        self.board = made

    def feed(self, event):
        from hannes.bench.grip_loop import Force

        if not isinstance(event, Row):
            return None
        force = self.board.logic.machine.truth["force"]
        return Force(event.time, force, force, force)

    def begin(self):
        """Nothing to forget."""


def test_what_is_held_stays_held_when_recognition_begins_anew(model, monkeypatch):
    """A longer grasp is another to the recogniser; the policy must not let go of its limit."""
    monkeypatch.setattr("hannes.bench.live.LONGEST", 1.2)
    loop = GripLoop(model)
    loop.feed(About("x", {"reference": "rad", "position": "rad", "current": "A"}, 1e3, 0.2), 0.0)
    for number, time in enumerate(np.arange(0.0, 1.6, 1e-3)):
        position = min(SPEED * time, 6.0)
        current = 0.3 + 0.1 * max(position - 5.0, 0.0)
        row = Row(number, float(time), (position, position, current))
        loop.feed(row, min(SPEED * time, FULL))
    assert not loop.firm
    assert loop.set_point < FULL - 0.5
