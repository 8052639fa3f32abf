"""A supply that falls from run to run: a value of the hand, moved by how many runs came before."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth.battery import FALL, RANGES, drained
from benchmarks.truth.campaign import make
from benchmarks.truth.parameters import NOMINAL
from benchmarks.truth.protocol import PAPER as CLOSURE
from benchmarks.truth.protocol import RICH, Condition, Protocol, scaled
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.settings import Settings
from hannes.plants.hand.falling_supply import falling_supply
from hannes.plants.hand.plant import HandPlant
from hannes.plants.part_fault import compiled_effects, moves_by_run

EFFECT = falling_supply()["falling_supply"]
HALF = scaled(CLOSURE, 0.5)


def test_it_adds_nothing_to_the_equations_and_moves_by_run():
    plant = HandPlant()
    assert plant.catalogue["falling_supply"] == EFFECT
    assert compiled_effects((EFFECT,)) == ()
    assert [n for n, each in plant.catalogue.items() if moves_by_run(each)] == ["falling_supply"]


@pytest.mark.parametrize("numbers", [[0], [4], [2, 5]])
def test_a_run_has_lost_as_much_as_runs_came_before(numbers):
    group = SimpleNamespace(owner="", own=(), nominal={}, numbers=np.array(numbers))
    space = ParameterSpace(HandPlant(), [group], Settings(), [EFFECT])
    row = np.zeros((1, space.size))
    place = int(space.of("falling_supply")[0])
    row[0, place] = space.parameters[place].x(0.1)
    lost = 12.0 - space.columns(group, row, effects=True)["supply.voltage"]
    assert lost == pytest.approx(0.1 * np.mean(numbers))
    assert space.by_run.sum() == 1


def test_the_truth_takes_a_share_of_what_is_left():
    volts = [drained(NOMINAL, {FALL: 0.1}, k)["supply.voltage"] for k in range(4)]
    assert volts[0] == NOMINAL["supply.voltage"]
    assert volts[0] - volts[1] == pytest.approx(0.1, rel=0.01)
    assert np.ptp(np.divide(volts[1:], volts[:-1])) < 1e-12
    assert RANGES[FALL].high <= EFFECT.parameters[0].bounds[1]


def test_a_campaign_of_the_truth_falls():
    runs = Protocol((Condition("void", CLOSURE, 3), Condition("void, half speed", HALF, 2)), RICH)
    made = make(runs, 5, {FALL: 0.2})
    logged = [float(np.median(each["supply"])) for each in made.recordings.values()]
    assert np.polyfit(range(5), logged, 1)[0] == pytest.approx(-0.2, abs=0.06)
