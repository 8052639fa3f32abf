"""Faults of parts in a search: what they move in a simulation, and the other parts tried."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.faults import Fault
from hannes.commands.diagnose import diagnose
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.settings import Settings
from hannes.plants.hand.finger_faults import FAULTS
from hannes.plants.hand.plant import HandPlant
from hannes.simulation.hand.hand_file import load_hand

CHOSEN = [FAULTS["index_weak_spring"], FAULTS["thumb_moved_stop"]]
GROUP = SimpleNamespace(owner="", own=(), nominal={})


@pytest.fixture(scope="module")
def space():
    return ParameterSpace(HandPlant(), [GROUP], Settings(), CHOSEN)


def rows(space, **sizes):
    """Two points: the machine as given, and one with amplitudes at these sizes [SI]."""
    found = np.zeros((2, space.size))
    for name, size in sizes.items():
        place = space.place(name.replace("__", "."))
        found[1, place] = space.parameters[place].x(size)
    return found


def test_a_fault_moves_the_values_of_its_part(space):
    at = rows(space, index_weak_spring__mcp_lost=0.3, thumb_moved_stop__pip_angle=-0.2)
    columns = space.columns(GROUP, at, True)
    hand = HandPlant().parameters
    assert columns["index.mcp_spring_stiffness"] == pytest.approx([1.0, 0.7])
    assert columns["index.mcp_spring_preload"] == pytest.approx([1.0, 0.7])
    # The stop's angle is uncertain itself: the fault is added to what it is there.
    assert columns["thumb.end_pip"] == pytest.approx(hand["thumb.end_pip"] + np.array([0.0, -0.2]))
    assert not {"index.pip_spring_stiffness", "index_weak_spring.mcp_lost"} & columns.keys()


def test_without_effects_and_at_none_nothing_is_moved(space):
    at = rows(space, index_weak_spring__mcp_lost=0.3)
    assert "index.mcp_spring_stiffness" not in space.columns(GROUP, at, False)
    assert "index.mcp_spring_stiffness" not in space.columns(GROUP, at[:1], True)


def test_values_of_a_machine_are_within_bounds(space):
    at = rows(space, index_weak_spring__mcp_lost=0.4, thumb_moved_stop__pip_angle=-0.2)[1]
    values = space.values(at)
    assert values["index.mcp_spring_stiffness"] == pytest.approx(0.6)
    HandPlant().with_values(values)
    assert space.declared("thumb_moved_stop.pip_angle").unit == "rad"


@pytest.mark.slow  # a diagnosis of the whole catalogue
def test_a_lost_spring_is_named_with_its_finger_and_written_as_its_value(tmp_path):
    weak = Fault("weak_spring", "thumb", "mcp", 0.8)
    made = make("poor", 77, {}, Spread(finger=0.005), fault=weak)
    made.write(tmp_path)
    verdict = diagnose(tmp_path / "campaign.toml", progress=False).verdict
    assert verdict.verdict in ("named", "named_with_remainder")
    assert verdict.effects == ["thumb_weak_spring"]
    assert verdict.parameters["thumb_weak_spring.mcp_lost"]["value"] == pytest.approx(0.8, abs=0.05)
    hand = load_hand(tmp_path / "diagnosis" / "hand.toml")
    assert hand.parameters["thumb.mcp_spring_stiffness"] == pytest.approx(0.2, abs=0.05)
