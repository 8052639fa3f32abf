"""Grasps by their own steps in lanes: the bits of one at a time, whatever shares the registers."""

from dataclasses import replace

import numpy as np
import pytest
from catalogued import CATALOGUE, EVERYTHING, RANGES
from runs import grasp

from hannes.core.kernels.jit import compiles
from hannes.simulation.batch import lanes as batch
from hannes.simulation.batch import own_steps
from hannes.simulation.batch.simulate_many import simulate_many
from hannes.simulation.compiler.lanes import machine
from hannes.simulation.experiment.experiment import Reference
from hannes.simulation.hand.hand import Hand
from hannes.simulation.trajectory import Outcome

pytestmark = pytest.mark.skipif(not compiles(), reason="nothing is compiled")
CHANNELS = ("position", "current", "force", "phalanx_force", "joint_angle", "motor_speed")
COUNT = 40
TURN = np.arange(COUNT)
FAR = {
    "object.stiffness": np.exp(np.linspace(np.log(800.0), np.log(5e4), COUNT)),
    "motor.dry_friction": Hand().parameters["motor.dry_friction"] * np.linspace(0.5, 2.0, COUNT),
}
# In turn: nothing to hold, soft and rigid objects, hands that hardly move.
MIXED = {
    "object.radius": np.where(TURN % 4 == 0, 1e-4, 0.025),
    "object.stiffness": np.where(TURN % 4 == 1, 700.0, 5e4),
    "motor.dry_friction": np.where(TURN % 4 == 3, 15.0, 1.0)
    * Hand().parameters["motor.dry_friction"],
}


@pytest.fixture
def lanes(monkeypatch):
    """Sets how many lanes there are, notes how many groups ran; their code is compiled at once."""
    monkeypatch.setattr(batch, "COMPILING", -1.0)
    run = own_steps.OwnSteps.run

    def noted(self, *given):
        chosen.ran.append(self.made.width)
        return run(self, *given)

    def chosen(width):
        monkeypatch.setattr(machine, "width", lambda: width)

    monkeypatch.setattr(own_steps.OwnSteps, "run", noted)
    chosen.ran = []
    return chosen


def bits(found):
    """What must be the same of grasps, seconds aside."""
    return [
        (
            *(each.number, each.outcome, each.cost.evaluations, each.cost.jacobians),
            *(each.time.tobytes(), *(each[name].tobytes() for name in CHANNELS)),
        )
        for each in found
    ]


def run(columns, hand=None, experiment=None, rtol=1e-4, workers=1):
    """A batch, many of them in a window."""
    hand, experiment = hand or Hand(), experiment or grasp(duration=0.7)
    how = {"channels": CHANNELS, "rtol": rtol, "effects": hand.effects, "workers": workers}
    return list(simulate_many(hand, experiment, columns, **how))


@pytest.mark.parametrize("columns", [FAR, MIXED], ids=["far", "mixed"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-2])
def test_lanes_have_the_bits_of_one_at_a_time(lanes, columns, rtol):
    lanes(1)
    expected = bits(run(columns, rtol=rtol))
    for width in (8, 4):
        lanes(width)
        assert bits(run(columns, rtol=rtol)) == expected
    assert set(lanes.ran) == {8, 4}


def test_bits_do_not_depend_on_order_or_workers(lanes):
    lanes(8)
    expected = dict(enumerate(bits(run(MIXED))))
    rows = np.random.default_rng(4).permutation(COUNT)
    mixed = {name: column[rows] for name, column in MIXED.items()}
    for workers in (1, 2):
        for row, found in zip(rows, bits(run(mixed, workers=workers)), strict=True):
            assert found[1:] == expected[int(row)][1:]
    assert set(lanes.ran) == {8}


def test_the_whole_catalogue_has_the_bits_of_one_at_a_time(lanes):
    names = [n for n in RANGES if n.partition(".")[0] in CATALOGUE]
    columns = {n: RANGES[n].low + 0.1 * (RANGES[n].high - RANGES[n].low) for n in names}
    columns["mcp.moment_arm"] = 0.01 * np.linspace(1.0, 1.1, COUNT)
    lanes(1)
    expected = bits(run(columns, EVERYTHING, grasp(duration=0.2)))
    assert expected[0][1] is Outcome.COMPLETED
    lanes(8)
    assert bits(run(columns, EVERYTHING, grasp(duration=0.2))) == expected
    assert set(lanes.ran) == {8}


def test_a_lane_that_breaks_is_named_and_touches_no_other(lanes):
    way = np.zeros(COUNT)
    way[[2, 5, 9, 30]] = 1.0, 2.0, 3.0, 1.0
    columns = {"breaking.way": way, "mcp.moment_arm": 0.01 * np.linspace(1.0, 1.01, COUNT)}
    found = {}
    for width in (1, 8):
        lanes(width)
        found[width] = run(columns, EVERYTHING, grasp(duration=0.2))
    assert bits(found[8]) == bits(found[1]) and set(lanes.ran) == {8}
    broken = [each.outcome is not Outcome.COMPLETED for each in found[8]]
    assert broken == (way != 0.0).tolist()


def test_a_reference_with_kinks_ends_steps_in_lanes_too(lanes):
    knots = np.array([[0.0, 0.1, 0.25, 0.5], [0.0, 0.5, 0.2, 1.0]])
    kinked = replace(grasp(duration=0.4), reference=Reference(knots, kinked=True))
    lanes(1)
    expected = bits(run(FAR, experiment=kinked))
    lanes(8)
    assert bits(run(FAR, experiment=kinked)) == expected and set(lanes.ran) == {8}


@pytest.mark.parametrize(("name", "value"), [("FEW", 1.0), ("IDLE", 1.0)])
def test_what_waits_for_others_goes_on_alone(lanes, monkeypatch, name, value):
    lanes(1)
    expected = bits(run(FAR))
    monkeypatch.setattr(own_steps, name, value)
    monkeypatch.setattr(own_steps, "TURN", 8)
    lanes(8)
    assert bits(run(FAR)) == expected and set(lanes.ran) == {8}


def test_rows_that_share_a_register_have_the_same_stages_and_are_alike():
    vectors = np.zeros((20, 4))
    vectors[:, 1], vectors[:, 2] = np.arange(20) % 2, np.arange(20) // 5
    vectors[:, 3] = np.random.default_rng(1).random(20)
    found = own_steps.groups(vectors, (1,), 8)
    assert sorted(np.concatenate(found).tolist()) == list(range(20))
    assert [each.size for each in found] == [8, 2, 8, 2]
    for rows in found:
        assert np.ptp(vectors[rows, 1]) == 0.0
        assert (np.diff(vectors[rows, 2]) >= 0.0).all()
    assert [each.tolist() for each in own_steps.groups(np.zeros((3, 4)), (), 8)] == [[0, 1, 2]]
