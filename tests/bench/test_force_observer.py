"""The observer on the stepper: force of a held object, its band, and a machine that leaves it."""

import numpy as np
import pytest

from hannes import Hand
from hannes.bench.force_observer import EFFECTS, ForceObserver, ObserverSettings
from hannes.bench.simulated_board import SimulatedBoard
from hannes.bench.virtual_hand import VirtualHand
from hannes.simulation.experiment.experiment import Experiment, Reference, Target

FULL, SPEED = 9.84, 9.84 / 0.637
HIDDEN = {"floating_object.free": 1.0, "gear_load.coefficient": 0.08}
SLACK = {"leader_slack.length": 1e-3}  # a model of its own, which the observer's twins are not
HELD = {"object.stiffness": 8e3, "object.radius": 0.025, "object.x": 0.015, "object.y": -0.046}


def machine(**values):
    """A hand that holds an object of which the observer knows nothing."""
    target = Target("cylinder", HELD)
    experiment = Experiment("held", 2.0, Reference([[0.0, 1.0], [0.0, 0.0]]), target)
    return VirtualHand(Hand(EFFECTS).with_values(HIDDEN | values), experiment)


def observed(ticks=1100, **values):
    """True force, estimate, ends of the band and residual [N], (ticks, 5)."""
    board, observer, rows = SimulatedBoard(machine(**values)), ForceObserver(), []
    events = board.send(board.speaker.ask())
    for tick in range(ticks):
        if tick % 5 == 0:
            events += board.send(board.speaker.set_point(min(SPEED * tick / 1e3, FULL)))
        if tick % 50 == 0:
            events += board.send(board.speaker.alive(tick))
        events += board.tick()
        for event in events:
            said = observer.feed(event)
            if said is not None:
                truth = board.logic.machine.truth["force"]
                rows.append((truth, said.value, said.low, said.high, said.residual))
        events = []
    return np.array(rows)


@pytest.fixture(scope="module")
def sound():
    return observed()


@pytest.mark.slow
def test_a_loose_wire_is_an_earlier_or_later_touch():
    loose = observed(**SLACK)
    assert off(loose) < 0.15 and inside(loose) > 0.8


def test_there_is_a_force_at_every_sample(sound):
    assert len(sound) == 1100
    assert np.isfinite(sound).all()


def off(found):
    """Median error of the force where an object is held, as a share."""
    on = found[:, 0] > 2.0
    return np.median(np.abs(found[on, 1] / found[on, 0] - 1.0))


def inside(found):
    """Share of the samples with an object held whose band holds the truth."""
    on = found[:, 0] > 2.0
    return ((found[on, 2] <= found[on, 0]) & (found[on, 0] <= found[on, 3])).mean()


def test_the_force_of_an_unknown_object_is_near_the_truth(sound):
    assert off(sound) < 0.15


def test_its_band_holds_the_truth(sound):
    assert inside(sound) > 0.8


def test_nothing_is_held_before_the_touch(sound):
    before = sound[:, 0] < 0.1
    assert np.median(sound[before, 1]) < 2.0


def test_a_machine_that_leaves_the_model_shows_in_the_residual(sound):
    rubbing = observed(500, **{"motor.dry_friction": 0.012})
    assert rubbing[-1, 4] > ObserverSettings().warning > sound[:, 4].max()
